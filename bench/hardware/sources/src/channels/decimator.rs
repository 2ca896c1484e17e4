//! Decimation of gauge samples to a lower rate, each filtered value with its frame.

use super::lowpass::Lowpass;

/// One filtered value per input.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filtered {
    /// Frame of the card to which the values belong.
    pub(super) frame: u64,
    /// Values of the inputs.
    pub(super) values: Vec<f64>,
    /// Whether a sample within the filter was at the end of its converter's range.
    pub(super) clipped: bool,
}

/// Filters and decimates the inputs of one sensor.
#[derive(Debug)]
pub(super) struct Decimator {
    factor: u64,
    half: u64,
    /// Taps of each input, oldest sample first.
    taps: Vec<Vec<f64>>,
    /// Samples of each input since frame `first`.
    history: Vec<Vec<f64>>,
    first: u64,
    /// Frame of the next value; `None` before the first sample.
    next: Option<u64>,
    /// Newest clipped frame.
    clipped: Option<u64>,
    /// Number of values lost to gaps.
    lost: u64,
}

impl Decimator {
    /// Creates a decimator by `factor`; `late` holds the sampling delay of each input within a frame, samples.
    pub(super) fn new(factor: usize, late: &[f64]) -> Self {
        let lowpass = Lowpass::new(factor);
        Self {
            factor: factor as u64,
            half: lowpass.half as u64,
            taps: late.iter().map(|&late| lowpass.taps(late)).collect(),
            history: vec![Vec::new(); late.len()],
            first: 0,
            next: None,
            clipped: None,
            lost: 0,
        }
    }

    /// Returns the number of values lost to gaps.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// Processes consecutive interleaved frames; the first has the number `first`. A gap or a non-finite sample loses all
    /// values with a filter that spans it. `clips` tells whether a sample is at the end of its converter's range. Returns the
    /// number of non-finite samples.
    pub(super) fn take(
        &mut self,
        first: u64,
        frames: &[f32],
        clips: impl Fn(f32) -> bool,
        mut give: impl FnMut(Filtered),
    ) -> u64 {
        let inputs = self.history.len();
        let mut not_finite = 0;
        for (i, frame) in frames.chunks_exact(inputs).enumerate() {
            let number = first + i as u64;
            if number != self.first + self.history[0].len() as u64 {
                self.begin(number);
            }
            let invalid_count = frame.iter().filter(|value| !value.is_finite()).count();
            if invalid_count > 0 {
                not_finite += invalid_count as u64;
                self.begin(number + 1);
                continue;
            }
            if frame.iter().any(|&value| clips(value)) {
                self.clipped = Some(number);
            }
            for (history, &value) in self.history.iter_mut().zip(frame) {
                history.push(f64::from(value));
            }
            let due = *self.next.get_or_insert_with(|| {
                // The grid follows the card's frame numbers, independent of gaps.
                (self.first + self.half).next_multiple_of(self.factor)
            });
            if number == due + self.half {
                give(self.value(due));
                self.next = Some(due + self.factor);
            }
        }
        self.forget();
        not_finite
    }

    /// Discards the samples before frame `first`, so that the filter never spans a gap.
    fn begin(&mut self, first: u64) {
        let restart = (first + self.half).next_multiple_of(self.factor);
        if let Some(due) = self.next {
            self.lost += restart.saturating_sub(due) / self.factor;
            self.next = Some(restart.max(due));
        }
        self.first = first;
        self.history.iter_mut().for_each(Vec::clear);
    }

    fn value(&self, frame: u64) -> Filtered {
        let start = (frame - self.half - self.first) as usize;
        let convolution = |(taps, history): (&Vec<f64>, &Vec<f64>)| {
            let samples = &history[start..start + taps.len()];
            taps.iter().zip(samples).map(|(tap, x)| tap * x).sum()
        };
        Filtered {
            frame,
            values: self
                .taps
                .iter()
                .zip(&self.history)
                .map(convolution)
                .collect(),
            clipped: self
                .clipped
                .is_some_and(|clipped_frame| clipped_frame >= frame - self.half),
        }
    }

    /// Drops samples that no later value needs.
    fn forget(&mut self) {
        let Some(due) = self.next else { return };
        let count = (due - self.half).saturating_sub(self.first);
        let count = (count as usize).min(self.history[0].len());
        for history in &mut self.history {
            history.drain(..count);
        }
        self.first += count as u64;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE_HZ: f64 = 96_000.0;

    /// Signal of two tones of a hand's movement and one of a plate.
    fn signal(sample: f64) -> f64 {
        let tone = |hz: f64| (TAU * hz * sample / RATE_HZ).sin();
        0.3 * tone(7.0) + 0.02 * tone(180.0) + 0.1 * tone(35_000.0)
    }

    fn slow(sample: f64) -> f64 {
        signal(sample) - 0.1 * (TAU * 35_000.0 * sample / RATE_HZ).sin()
    }

    fn frames(numbers: std::ops::Range<u64>, late: &[f64]) -> Vec<f32> {
        numbers
            .flat_map(|n| late.iter().map(move |late| signal(n as f64 + late) as f32))
            .collect()
    }

    fn no_clipping(_: f32) -> bool {
        false
    }

    #[test]
    fn values_match_their_frame_at_any_block_length_and_skew() {
        let late = [0.0, 0.4, 3.2];
        let samples = frames(0..20_000, &late);
        let mut values = Vec::new();
        let mut decimator = Decimator::new(24, &late);
        decimator.take(0, &samples, no_clipping, |value| values.push(value));
        assert!(values.len() > 780);
        for value in &values {
            assert_eq!(value.frame % 24, 0);
            for &read in &value.values {
                let error = read - slow(value.frame as f64);
                // One sample of delay is 3e-4 where the signal is steepest.
                assert!(error.abs() < 2e-5, "{error}");
            }
        }
        let (mut pieces, mut decimator) = (Vec::new(), Decimator::new(24, &late));
        let (mut from, mut length) = (0, 1);
        while from < 20_000 {
            let to = (from + length).min(20_000);
            let block = &samples[3 * from..3 * to];
            decimator.take(from as u64, block, no_clipping, |value| pieces.push(value));
            (from, length) = (to, length * 7 % 1003 + 1);
        }
        assert_eq!(pieces, values);
        assert_eq!(decimator.lost(), 0);
    }

    /// Fault 46.
    #[test]
    fn a_gap_costs_the_values_that_reach_over_it_and_each_is_counted() {
        let late = [0.0, 0.0];
        let (mut values, mut decimator) = (Vec::new(), Decimator::new(24, &late));
        decimator.take(0, &frames(0..5000, &late), no_clipping, |value| {
            values.push(value.frame)
        });
        let (gap_index, gap_to) = (values.len(), 5777);
        let block = frames(gap_to..9000, &late);
        decimator.take(gap_to, &block, no_clipping, |value| {
            assert!((value.values[0] - slow(value.frame as f64)).abs() < 2e-5);
            values.push(value.frame);
        });
        let missing = (values[gap_index] - values[gap_index - 1]) / 24 - 1;
        assert_eq!(decimator.lost(), missing);
        assert!(values.iter().all(|frame| frame % 24 == 0));

        // A non-finite sample is a gap of one frame.
        let mut block = frames(9000..12_000, &late);
        block[1001] = f32::NAN;
        block[2000] = f32::INFINITY;
        let (lost, count) = (decimator.lost(), values.len());
        let invalid_count = decimator.take(9000, &block, no_clipping, |value| {
            assert!(value.values.iter().all(|value| value.is_finite()));
            values.push(value.frame);
        });
        assert_eq!(invalid_count, 2);
        let expected = (values[values.len() - 1] - values[count - 1]) / 24;
        assert_eq!(
            decimator.lost() - lost,
            expected - (values.len() - count) as u64
        );
        assert!(decimator.lost() > lost);
    }

    /// Fault 46.
    #[test]
    fn a_clipped_sample_is_told_with_the_very_next_value() {
        let (mut values, mut decimator) = (Vec::new(), Decimator::new(24, &[0.0]));
        let mut block = frames(0..6000, &[0.0]);
        block[3000] = 1.0;
        decimator.take(0, &block, |x| x >= 1.0, |value| values.push(value));
        let first = values.iter().find(|value| value.clipped).unwrap();
        let flagged_frame = first.frame + decimator.half;
        assert!(
            (3000..3000 + 24).contains(&flagged_frame),
            "{flagged_frame}"
        );
        let last = values.iter().rfind(|value| value.clipped).unwrap();
        assert!(last.frame - decimator.half <= 3000);
    }
}
