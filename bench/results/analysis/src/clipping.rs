//! Detects clipping of a wave by the number of samples at its largest value.

/// Largest and smallest sample values, with their counts.
#[derive(Debug, Default)]
pub(super) struct Extremes {
    pub(super) lost_samples: u64,
    top: Extreme,
    bottom: Extreme,
}

/// Largest value so far, its count, and the count of values just below it.
#[derive(Debug, Default)]
struct Extreme {
    value: f32,
    count: u64,
    near_count: u64,
}

/// Fraction of the largest value above which a value counts as just below it.
const NEAR_FRACTION: f32 = 0.999;
/// Smallest number of samples at the largest value of a clipped wave, and smallest ratio to those just below it.
const MIN_CLIPPED_SAMPLES: u64 = 16;
const MIN_CLIPPED_RATIO: u64 = 4;

impl Extreme {
    fn take(&mut self, value: f32) {
        if value > self.value {
            self.near_count = if self.value > NEAR_FRACTION * value {
                self.near_count + self.count
            } else {
                0
            };
            (self.value, self.count) = (value, 1);
        } else if value == self.value {
            self.count += 1;
        } else if value > NEAR_FRACTION * self.value {
            self.near_count += 1;
        }
    }

    fn is_clipped(&self) -> bool {
        self.value > 0.0
            && self.count >= MIN_CLIPPED_SAMPLES
            && self.count > MIN_CLIPPED_RATIO * self.near_count
    }
}

impl Extremes {
    pub(super) fn take(&mut self, value: f32) {
        if value.is_finite() {
            self.top.take(value);
            self.bottom.take(-value);
        } else {
            self.lost_samples += 1;
        }
    }

    /// Returns the largest |sample|.
    pub(super) fn level(&self) -> f32 {
        self.top.value.max(self.bottom.value)
    }

    /// Returns the number of clipped samples and their magnitude.
    pub(super) fn clipping(&self) -> Option<(u64, f32)> {
        let clipped_extremes = [&self.top, &self.bottom]
            .into_iter()
            .filter(|e| e.is_clipped());
        clipped_extremes
            .map(|extreme| (extreme.count, extreme.value))
            .reduce(|a, b| (a.0 + b.0, a.1.min(b.1)))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn extremes(values: impl Iterator<Item = f64>) -> Extremes {
        let mut extremes = Extremes::default();
        values.for_each(|x| extremes.take(x as f32));
        extremes
    }

    /// Returns a 35 kHz wave with 6 Hz modulation at 192 kHz.
    fn wave() -> impl Iterator<Item = f64> {
        (0..192_000).map(|i| {
            let t = f64::from(i) / 192e3;
            let envelope = 1.0 + 0.95 * (TAU * 6.0 * t).sin();
            0.4 * envelope * (TAU * 35e3 * t).cos()
        })
    }

    #[test]
    fn a_clipped_wave_is_distinguished_from_an_unclipped_one() {
        assert_eq!(extremes(wave()).clipping(), None);
        // With 16 bits, the crest stays at one code for a while.
        assert_eq!(
            extremes(wave().map(|x| (x * 32768.0).round() / 32768.0)).clipping(),
            None
        );
        let (samples, level) = extremes(wave().map(|x| x.clamp(-0.7, 0.7)))
            .clipping()
            .unwrap();
        assert_eq!(level, 0.7);
        assert!(samples > 1000, "{samples}");
        // Only one side, as with DC.
        let (_, level) = extremes(wave().map(|x| (x + 0.1).min(0.8)))
            .clipping()
            .unwrap();
        assert_eq!(level, 0.8);
    }
}
