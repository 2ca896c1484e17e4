//! Detects clipping of a wave by the number of samples at its ends.
//!
//! A wave that was cut off is at its greatest value far more often than just below. The crest of a sine at A falls into the last of
//! equal steps δ of a converter for a share √(2δ/A)/π of the time, and into the step before for √2 − 1 times as long: a coarse converter
//! has up to 2.4 times as many samples at the top as in the step below.

/// Extremes of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extremes {
    lost: u64,
    top: Extreme,
    bottom: Extreme,
}

/// Samples at the ends of a channel that was cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipping {
    /// Number of samples there.
    pub samples: u64,
    /// Their magnitude; the lesser one, if both ends were cut off.
    pub magnitude: f64,
}

/// Largest value so far, its count, the count of values just below it, and the next largest value with its count.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extreme {
    value: f64,
    count: u64,
    near_count: u64,
    next: f64,
    next_count: u64,
}

/// Fraction of the largest value above which a value counts as just below it.
const NEAR_FRACTION: f64 = 0.999;
/// Fraction of the largest value above which the next largest one may be a converter's next step.
const STEP_FRACTION: f64 = 0.95;
/// Smallest number of samples at the largest value of a clipped wave, and smallest ratio to those just below it.
const MIN_CLIPPED_SAMPLES: u64 = 16;
const MIN_CLIPPED_RATIO: u64 = 4;

impl Default for Extreme {
    fn default() -> Self {
        Self {
            value: f64::NEG_INFINITY,
            count: 0,
            near_count: 0,
            next: f64::NEG_INFINITY,
            next_count: 0,
        }
    }
}

impl Extreme {
    fn take(&mut self, value: f64) {
        if value > self.value {
            self.near_count = if self.value > NEAR_FRACTION * value {
                self.near_count + self.count
            } else {
                0
            };
            (self.next, self.next_count) = (self.value, self.count);
            (self.value, self.count) = (value, 1);
        } else if value == self.value {
            self.count += 1;
        } else {
            if value > NEAR_FRACTION * self.value {
                self.near_count += 1;
            }
            if value > self.next {
                (self.next, self.next_count) = (value, 1);
            } else if value == self.next {
                self.next_count += 1;
            }
        }
    }

    fn is_clipped(&self) -> bool {
        let is_step = self.next > STEP_FRACTION * self.value;
        let below = self
            .near_count
            .max(if is_step { self.next_count } else { 0 });
        self.value > 0.0
            && self.count >= MIN_CLIPPED_SAMPLES
            && self.count > MIN_CLIPPED_RATIO * below
    }
}

impl Extremes {
    /// Takes a sample.
    pub fn take(&mut self, value: f64) {
        if value.is_finite() {
            self.top.take(value);
            self.bottom.take(-value);
        } else {
            self.lost += 1;
        }
    }

    /// Returns the number of samples that are not numbers.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns the least sample; ∞ without samples.
    #[must_use]
    pub fn least(&self) -> f64 {
        -self.bottom.value
    }

    /// Returns the greatest sample; −∞ without samples.
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.top.value
    }

    /// Returns the largest |sample|; 0 without samples.
    #[must_use]
    pub fn level(&self) -> f64 {
        self.top.value.max(self.bottom.value).max(0.0)
    }

    /// Returns the samples at which the channel was cut off.
    #[must_use]
    pub fn clipping(&self) -> Option<Clipping> {
        let ends = [&self.top, &self.bottom].into_iter();
        let clipped = ends.filter(|extreme| extreme.is_clipped());
        let clipped = clipped.map(|extreme| Clipping {
            samples: extreme.count,
            magnitude: extreme.value,
        });
        clipped.reduce(|a, b| Clipping {
            samples: a.samples + b.samples,
            magnitude: a.magnitude.min(b.magnitude),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn clipping(values: impl Iterator<Item = f64>) -> Option<Clipping> {
        let mut extremes = Extremes::default();
        values.for_each(|value| extremes.take(value));
        extremes.clipping()
    }

    /// A 35 kHz wave with 6 Hz modulation at 192 kHz.
    fn wave() -> impl Iterator<Item = f64> {
        (0..192_000).map(|i| {
            let t = f64::from(i) / 192e3;
            let envelope = 1.0 + 0.95 * (TAU * 6.0 * t).sin();
            0.4 * envelope * (TAU * 35e3 * t).cos()
        })
    }

    #[test]
    fn a_clipped_wave_is_told_from_a_whole_one_with_any_converter() {
        assert_eq!(clipping(wave()), None);
        for bits in [16, 12, 10, 8] {
            let step = 2f64.powi(1 - bits);
            let read = |x: f64| (x / step).round() * step;
            assert_eq!(clipping(wave().map(read)), None, "{bits} bits");
            let cut = clipping(wave().map(|x| read(x.clamp(-0.6, 0.6)))).unwrap();
            assert_eq!(cut.magnitude, read(0.6), "{bits} bits");
            assert!(cut.samples > 1000, "{cut:?}");
            let steady = (0..100_000).map(|n| read(0.9 * (TAU * 0.012_34 * f64::from(n)).sin()));
            assert_eq!(clipping(steady), None, "{bits} bits");
        }
        // Only one side, as with an offset.
        let cut = clipping(wave().map(|x| (x + 0.1).min(0.8))).unwrap();
        assert_eq!(cut.magnitude, 0.8);
    }

    #[test]
    fn extremes_and_lost_samples_are_counted() {
        let mut extremes = Extremes::default();
        assert_eq!(extremes.level(), 0.0);
        for value in [0.5, f64::NAN, -0.7, 0.2] {
            extremes.take(value);
        }
        assert_eq!((extremes.least(), extremes.greatest()), (-0.7, 0.5));
        assert_eq!((extremes.level(), extremes.lost()), (0.7, 1));
    }
}
