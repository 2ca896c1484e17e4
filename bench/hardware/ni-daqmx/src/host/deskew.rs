//! Alignment of the samples of a card with one converter, which takes its inputs one after the other.
//!
//! All code behind the card takes the samples of a frame to be simultaneous. A delay of the pickup against the drive is
//! a phase at the carrier, which a calibration would include, but that phase is different at another carrier and at
//! each sideband. The delay is known from the converter's rate and is removed as such: each input is interpolated to
//! the instant of the first by a windowed sinc.

use std::f64::consts::PI;

/// Half the length of the interpolation, samples: the delay that it adds to every input.
pub(super) const HALF: usize = 24;
const TAPS: usize = 2 * HALF + 1;
/// Shape of the Kaiser window: with [`HALF`] flat to 1e-4 up to 0.86 of half the sample rate.
const BETA: f64 = 9.0;

/// Interpolates the inputs of interleaved frames.
pub(super) struct Deskew {
    inputs: Vec<Input>,
}

struct Input {
    /// Weights, oldest sample first; a pure delay for an input on time.
    weights: [f64; TAPS],
    /// The last samples, stored twice, so that they lie in order from any position.
    ring: [f64; 2 * TAPS],
    position: usize,
}

impl Deskew {
    /// Makes an interpolation for inputs that are late by these numbers of samples, each less than one frame.
    pub(super) fn new(late_samples: impl Iterator<Item = f64>) -> Self {
        let input = |late: f64| Input {
            weights: std::array::from_fn(|tap| {
                // Oldest first: the tap's sample was taken this long before the requested instant.
                let age = tap as f64 - HALF as f64 + late;
                windowed_sinc(age)
            }),
            ring: [0.0; 2 * TAPS],
            position: 0,
        };
        Self {
            inputs: late_samples.map(input).collect(),
        }
    }

    /// Replaces the samples of interleaved frames by simultaneous samples, [`HALF`] frames earlier.
    pub(super) fn take(&mut self, frames: &mut [f64]) {
        for frame in frames.chunks_exact_mut(self.inputs.len()) {
            for (sample, input) in frame.iter_mut().zip(&mut self.inputs) {
                input.ring[input.position] = *sample;
                input.ring[input.position + TAPS] = *sample;
                input.position = (input.position + 1) % TAPS;
                let last = &input.ring[input.position..input.position + TAPS];
                *sample = last.iter().zip(&input.weights).map(|(x, w)| x * w).sum();
            }
        }
    }
}

fn windowed_sinc(x: f64) -> f64 {
    let edge = x / (HALF as f64 + 1.0);
    if x == 0.0 {
        return 1.0;
    }
    if edge.abs() >= 1.0 {
        return 0.0;
    }
    (PI * x).sin() / (PI * x) * bessel(BETA * (1.0 - edge * edge).sqrt()) / bessel(BETA)
}

/// Returns the modified Bessel function of the first kind and order 0, by its series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for n in 1..40 {
        term *= (0.5 * x / f64::from(n)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Returns the largest error of the second of two inputs that read one tone, the second later by `late` samples.
    fn error(tone: f64, late: f64) -> f64 {
        let sample_at = |input: f64, n: f64| (TAU * tone * (n + input * late)).sin();
        let mut frames: Vec<f64> = (0..2000)
            .flat_map(|n| [0.0, 1.0].map(|input| sample_at(input, f64::from(n))))
            .collect();
        Deskew::new([0.0, late].into_iter()).take(&mut frames);
        let settled = frames.chunks_exact(2).enumerate().skip(TAPS);
        settled
            .map(|(n, pair)| {
                let true_value = sample_at(0.0, n as f64 - HALF as f64);
                (pair[0] - true_value)
                    .abs()
                    .max((pair[1] - true_value).abs())
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn inputs_of_one_converter_are_brought_to_one_instant_at_every_frequency() {
        // 4 µs at 100 kHz and at 125 kHz, 1 µs at 250 kHz.
        for (late, rate_hz) in [(0.4, 100e3), (0.5, 125e3), (0.25, 250e3), (0.999, 100e3)] {
            for tone_hz in [0.0, 50.0, 1e3, 20e3, 34.9e3, 35e3, 42e3] {
                let error = error(tone_hz / rate_hz, late);
                assert!(error < 1e-4, "{late} at {tone_hz} Hz of {rate_hz}: {error}");
            }
        }
    }

    #[test]
    fn inputs_on_time_are_only_delayed() {
        assert!(error(0.35, 0.0) < 1e-15);
    }
}
