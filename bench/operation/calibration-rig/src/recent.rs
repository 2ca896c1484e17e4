//! Amplitude of an input over its latest samples.

use std::collections::VecDeque;

/// The latest samples of an input.
#[derive(Debug)]
pub(crate) struct Recent {
    samples: VecDeque<f64>,
    most: usize,
}

impl Recent {
    /// Keeps the latest `most` samples.
    pub(crate) fn new(most: usize) -> Self {
        Self {
            samples: VecDeque::with_capacity(most),
            most,
        }
    }

    /// Adds the samples of one channel of `block`, which consists of interleaved frames of `channels` samples.
    pub(crate) fn take(&mut self, block: &[f32], channels: usize, channel: usize) {
        for &sample in block.iter().skip(channel).step_by(channels) {
            if self.samples.len() == self.most {
                self.samples.pop_front();
            }
            self.samples.push_back(f64::from(sample));
        }
    }

    /// Returns the number of samples behind the amplitude.
    pub(crate) fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns the peak amplitude at any frequency; `None` without samples, or if some are not finite.
    pub(crate) fn amplitude(&self) -> Option<f64> {
        let n = self.samples.len() as f64;
        let mean = self.samples.iter().sum::<f64>() / n;
        let power = self.samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        power.is_finite().then(|| (2.0 * power).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn amplitude_is_that_of_the_latest_tone_without_its_offset() {
        let mut recent = Recent::new(192);
        assert_eq!(recent.amplitude(), None);
        let tone = |amplitude: f32| -> Vec<f32> {
            let sample = |i: u16| {
                [
                    0.1,
                    0.3 + amplitude * (TAU * f32::from(i) * 35.0 / 192.0).sin(),
                ]
            };
            (0..192).flat_map(sample).collect()
        };
        for amplitude in [0.5, 0.02] {
            recent.take(&tone(amplitude), 2, 1);
            let amplitude_read = recent.amplitude().unwrap();
            assert!(
                (amplitude_read - f64::from(amplitude)).abs() < 1e-5,
                "{amplitude_read}"
            );
        }
        assert_eq!(recent.len(), 192);
        recent.take(&[0.0, f32::NAN], 2, 1);
        assert_eq!(recent.amplitude(), None);
    }
}
