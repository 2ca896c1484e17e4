//! Inputs of the sound card: skew, crosstalk, noise, clipping, quantisation.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::scenario::ConverterTable;
use crate::seed;

/// Sampling moment of a channel, and the delay of its output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tap {
    /// Position within the sample interval, 0 to 1.
    pub moment: f64,
    /// Delay, whole samples.
    pub samples: usize,
}

/// Delay of the inputs behind the simulated interval, samples, so that channels can lead as well as lag.
pub(crate) const LATENCY: usize = 8;
const DEPTH: usize = 32;

impl Tap {
    /// Returns the tap of a channel sampled `offset_samples` later than nominal; |offset| must be below [`LATENCY`].
    pub fn new(offset_samples: f64) -> Self {
        let total = offset_samples - LATENCY as f64;
        Self {
            moment: total - total.floor(),
            samples: (-total.floor()) as usize,
        }
    }
}

/// Delay line of one channel, in whole samples.
#[derive(Debug, Clone)]
pub(crate) struct Delay {
    ring: [f64; DEPTH],
    cursor: usize,
    samples: usize,
}

impl Delay {
    pub fn new(tap: Tap) -> Self {
        Self {
            ring: [0.0; DEPTH],
            cursor: 0,
            samples: tap.samples,
        }
    }

    /// Discards the samples in the line.
    pub fn clear(&mut self) {
        self.ring = [0.0; DEPTH];
    }

    #[inline]
    pub fn push(&mut self, value: f64) -> f64 {
        self.ring[self.cursor] = value;
        let out = self.ring[(self.cursor + DEPTH - self.samples) % DEPTH];
        self.cursor = (self.cursor + 1) % DEPTH;
        out
    }
}

/// Converts ideal channel values to sample values.
#[derive(Debug, Clone)]
pub(crate) struct Converter {
    gains: Vec<f64>,
    crosstalk: f64,
    offset: f64,
    noise: f64,
    clip: f64,
    step: f64,
    rng: ChaCha8Rng,
}

impl Converter {
    pub fn new(scenario: &ConverterTable, rate_hz: f64, seed: u64) -> Self {
        Self {
            gains: (0..scenario.channels).map(|ch| scenario.gain(ch)).collect(),
            crosstalk: scenario.crosstalk,
            offset: scenario.offset_units,
            noise: scenario.noise_units_per_sqrt_hz * (0.5 * rate_hz).sqrt(),
            clip: scenario.clip_units,
            step: 2.0 / f64::from(scenario.bits).exp2(),
            rng: seed::stream(seed, seed::RandomStream::ConverterNoise),
        }
    }

    /// Converts one frame; channels beyond `ideal` are silent.
    #[inline]
    pub fn frame(&mut self, ideal: &[f64], out: &mut [f32]) {
        // Adding and subtracting 1.5·2⁵² rounds to nearest even
        const ROUND: f64 = 6_755_399_441_055_744.0;
        let aggressor = self.gains[0] * ideal[0];
        for (channel, (sample, gain)) in out.iter_mut().zip(&self.gains).enumerate() {
            let mut value = gain * ideal.get(channel).copied().unwrap_or(0.0) + self.offset;
            if channel > 0 {
                value += self.crosstalk * aggressor;
            }
            if self.noise > 0.0 {
                let white: f64 = StandardNormal.sample(&mut self.rng);
                value += self.noise * white;
            }
            let counts = (value / self.step + ROUND) - ROUND;
            *sample = (counts * self.step).clamp(-self.clip, self.clip) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tap_reads_earlier_or_later() {
        assert_eq!(
            Tap::new(0.0),
            Tap {
                moment: 0.0,
                samples: LATENCY
            }
        );
        assert_eq!(
            Tap::new(0.25),
            Tap {
                moment: 0.25,
                samples: LATENCY
            }
        );
        assert_eq!(
            Tap::new(-0.25),
            Tap {
                moment: 0.75,
                samples: LATENCY + 1
            }
        );
    }

    #[test]
    fn quantises_to_its_bits_and_clips() {
        let scenario = ConverterTable {
            bits: 8,
            clip_units: 0.9,
            noise_units_per_sqrt_hz: 0.0,
            crosstalk: 0.5,
            ..ConverterTable::default()
        };
        let mut converter = Converter::new(&scenario, 192e3, 1);
        let mut out = [0.0; 4];
        converter.frame(&[0.1, 2.0], &mut out);
        assert_eq!(out, [13.0 / 128.0, 0.9, 6.0 / 128.0, 6.0 / 128.0]);
    }

    #[test]
    fn each_input_has_its_gain_and_leaks_its_signal() {
        let scenario = ConverterTable {
            gains: vec![2.0, -0.5],
            bits: 32,
            noise_units_per_sqrt_hz: 0.0,
            crosstalk: 0.25,
            ..ConverterTable::default()
        };
        let mut converter = Converter::new(&scenario, 192e3, 1);
        let mut out = [0.0; 4];
        converter.frame(&[0.25, 0.25, 0.25], &mut out);
        assert_eq!(out, [0.5, 0.0, 0.375, 0.125]);
    }

    #[test]
    fn noise_has_its_density() {
        let scenario = ConverterTable {
            noise_units_per_sqrt_hz: 1e-5,
            ..ConverterTable::default()
        };
        let mut converter = Converter::new(&scenario, 200e3, 1);
        let (mut out, mut sum) = ([0.0f32; 1], 0.0);
        for _ in 0..20_000 {
            converter.frame(&[0.0], &mut out);
            sum += f64::from(out[0]).powi(2);
        }
        let density = (sum / 20_000.0 / 100e3).sqrt();
        assert!((density / 1e-5 - 1.0).abs() < 0.02, "{density}");
    }
}
