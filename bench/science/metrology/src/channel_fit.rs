//! Comparison of a channel with another that carries the same signal: gain, phase, delay, and slips by whole samples.

use crate::fitted_value::FittedValue;
use crate::regression::{FittedLine, LineFitError, LinePoint};
use num_complex::Complex64;
use statistics::wrap_rad;
use std::f64::consts::{PI, TAU};

/// The ratio of the two channels' envelopes at one tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioReading {
    /// Frequency of the tone, Hz.
    pub frequency_hz: f64,
    /// Ratio of the channel's envelope to the reference's.
    pub ratio: Complex64,
    /// Standard deviation of each quadrature of the ratio, relative to the magnitude.
    pub sigma: f64,
}

/// Gain, phase and delay of a channel against the reference over the band.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelFit {
    /// |ratio| at the carrier.
    pub gain: FittedValue,
    /// Phase of the ratio at the carrier, −π to π, rad.
    pub phase_rad: FittedValue,
    /// Delay of the channel against the reference, s: minus the slope of the phase, unambiguous as long as
    /// neighbouring tones differ by less than half a turn.
    pub delay_s: FittedValue,
    /// Excess of the slope's delay over that of the phase at the carrier, s: 0 for a pure delay. Filters and the images
    /// of converters cause it.
    pub excess_s: f64,
    /// Whether the phase lacks half a turn, because the wires are exchanged.
    pub inverted: bool,
    /// Root mean square departure of the ratios from a constant gain and the pure delay of the carrier's phase,
    /// relative: the residual of a correction by two numbers.
    pub departure: f64,
    /// Degrees of freedom: number of readings minus two.
    pub degrees_of_freedom: usize,
}

/// A slip of the channel by whole samples during the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleSlip {
    /// Samples by which the channel fell behind; negative when the reference did.
    pub samples: i32,
    /// Index of the first reading after the slip.
    pub reading: usize,
}

impl ChannelFit {
    /// Fits `readings`, in any order; phases are unwrapped from each tone to the next higher one.
    ///
    /// Straight lines over frequency, weighted, through magnitude and phase; errors come from the readings' deviations
    /// or from their scatter where that is more. 41 tones over 4 kHz at 1e-5: delay to 1e-9 s, gain and phase to 2e-6
    /// (`intervals_hold_the_truth`).
    ///
    /// # Errors
    /// When the readings determine no line.
    pub fn fit(readings: &[RatioReading], carrier_hz: f64) -> Result<Self, LineFitError> {
        let mut sorted = readings.to_vec();
        sorted.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let mut phase = 0.0;
        let mut previous = Complex64::ONE;
        let mut phases = Vec::with_capacity(sorted.len());
        for reading in &sorted {
            phase += (reading.ratio / previous).arg();
            previous = reading.ratio;
            phases.push(phase);
        }
        let points = |value: &dyn Fn(usize) -> (f64, f64)| -> Vec<LinePoint> {
            (0..sorted.len())
                .map(|i| {
                    let (y, sigma) = value(i);
                    LinePoint {
                        x: sorted[i].frequency_hz - carrier_hz,
                        y,
                        sigma,
                    }
                })
                .collect()
        };
        let turning = FittedLine::fit(&points(&|i| (phases[i], sorted[i].sigma)))?;
        let size = FittedLine::fit(&points(&|i| {
            let gain = sorted[i].ratio.norm();
            (gain, sorted[i].sigma * gain)
        }))?;
        let (gain, delay_s) = (size.offset, -turning.slope / TAU);
        // A pure delay d, of either polarity: arg = −2πf d (+ π) = −2πf_c d (+ π) − 2π(f − f_c) d. The slope of the phase gives
        // d, and the phase at f_c plus 2πf_c d is 0 or π. The rest, over 2πf_c, is the slope's delay less that of the phase.
        let unexplained_rad = wrap_rad(turning.offset + TAU * carrier_hz * delay_s);
        // For a pure delay, phase and slope agree; the phase of an inverted channel is off by half a turn.
        let inverted = unexplained_rad.abs() > PI / 2.0;
        let half_turn = if inverted { PI } else { 0.0 };
        let excess_s = wrap_rad(unexplained_rad - half_turn) / (TAU * carrier_hz);
        let mut fit = Self {
            gain: FittedValue {
                value: gain,
                standard_error: size.offset_error,
            },
            phase_rad: FittedValue {
                value: wrap_rad(turning.offset),
                standard_error: turning.offset_error,
            },
            delay_s: FittedValue {
                value: delay_s,
                standard_error: turning.slope_error / TAU,
            },
            excess_s,
            inverted,
            departure: 0.0,
            degrees_of_freedom: turning.degrees_of_freedom,
        };
        let squares: f64 = sorted
            .iter()
            .map(|reading| fit.departure_of(reading, carrier_hz).norm_sqr())
            .sum();
        fit.departure = (squares / sorted.len() as f64).sqrt();
        Ok(fit)
    }

    /// Returns the relative deviation of a reading from a constant gain and the pure delay of the carrier's phase:
    /// the real part in size, the imaginary part in phase, rad.
    #[must_use]
    pub fn departure_of(&self, reading: &RatioReading, carrier_hz: f64) -> Complex64 {
        let offset_hz = reading.frequency_hz - carrier_hz;
        let pure_delay_s = self.delay_s.value - self.excess_s;
        let angle = self.phase_rad.value - TAU * offset_hz * pure_delay_s;
        reading.ratio / Complex64::from_polar(self.gain.value, angle) - 1.0
    }
}

/// Deviation from one line over frequency above which a slip is searched for, rad: a hundred times that of converters.
const RAGGED_RAD: f64 = 0.02;
/// Largest slip that is searched for, samples.
const MOST_SLIP: i32 = 16;
/// Largest fraction of the deviation that may remain once the slip is undone.
const EXPLAINED: f64 = 0.1;

/// Returns the slip by whole samples at some point of `readings`, which are in order of time; `None` without a slip.
#[must_use]
pub fn find_slip(
    readings: &[RatioReading],
    carrier_hz: f64,
    sample_rate_hz: f64,
) -> Option<SampleSlip> {
    let departure = |readings: &[RatioReading]| {
        ChannelFit::fit(readings, carrier_hz).map_or(f64::INFINITY, |fit| fit.departure)
    };
    let raggedness = departure(readings);
    if raggedness < RAGGED_RAD {
        return None;
    }
    let slips = (-MOST_SLIP..=MOST_SLIP).filter(|&samples| samples != 0);
    let best = slips
        .flat_map(|samples| (1..readings.len()).map(move |reading| SampleSlip { samples, reading }))
        .map(|slip| {
            let mut corrected = readings.to_vec();
            for reading in &mut corrected[slip.reading..] {
                // k samples late: e^{−2πi f k/rate}, undone by its conjugate.
                let turn = TAU * reading.frequency_hz / sample_rate_hz;
                reading.ratio *= Complex64::cis(turn * f64::from(slip.samples));
            }
            (departure(&corrected), slip)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 < EXPLAINED * raggedness).then_some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const CARRIER_HZ: f64 = 35_010.0;
    const RATE_HZ: f64 = 192e3;

    /// 41 tones upwards and again downwards.
    fn readings(gain: f64, delay_s: f64, sigma: f64, seed: u64) -> Vec<RatioReading> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ascending = (0..41).map(|i| CARRIER_HZ - 2e3 + 100.0 * f64::from(i));
        ascending
            .clone()
            .chain(ascending.rev())
            .map(|frequency_hz| {
                let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
                let noise = sigma * Complex64::new(white(), white());
                let turn = Complex64::cis(-TAU * frequency_hz * delay_s);
                RatioReading {
                    frequency_hz,
                    ratio: gain * turn * (1.0 + noise),
                    sigma,
                }
            })
            .collect()
    }

    #[test]
    fn whole_samples_and_fractions_of_any_sign_are_resolved() {
        for samples in [-300.0, -17.25, -1.0, 0.0, 0.4, 3.0, 5.486, 11.0, 320.7] {
            let delay_s = samples / RATE_HZ;
            let fit = ChannelFit::fit(&readings(0.7, delay_s, 1e-9, 1), CARRIER_HZ).unwrap();
            assert_abs_diff_eq!(fit.delay_s.value * RATE_HZ, samples, epsilon = 1e-6);
            assert_abs_diff_eq!(fit.gain.value, 0.7, epsilon = 1e-9);
            assert!(!fit.inverted && fit.excess_s.abs() < 1e-11);
            assert!(fit.departure < 1e-8);
        }
        let inverted = ChannelFit::fit(&readings(-0.7, 1e-6, 1e-9, 1), CARRIER_HZ).unwrap();
        assert!(inverted.inverted && inverted.excess_s.abs() < 1e-11);
    }

    #[test]
    fn intervals_hold_the_truth() {
        let (gain, delay_s) = (0.97, 2.4 / RATE_HZ);
        let phase = wrap_rad(-TAU * CARRIER_HZ * delay_s);
        let mut covered = [0; 3];
        for seed in 0..1000 {
            let fit = ChannelFit::fit(&readings(gain, delay_s, 1e-5, seed), CARRIER_HZ).unwrap();
            let estimates = [
                (fit.gain, gain),
                (fit.phase_rad, phase),
                (fit.delay_s, delay_s),
            ];
            for (covered, (estimate, truth)) in covered.iter_mut().zip(estimates) {
                *covered +=
                    u32::from((estimate.value - truth).abs() <= 1.99 * estimate.standard_error);
            }
            assert!(fit.delay_s.standard_error < 1e-9 && fit.gain.standard_error < 2e-6);
            assert!(
                (fit.departure / 1.41e-5 - 1.0).abs() < 0.4,
                "{}",
                fit.departure
            );
        }
        assert!(
            covered.iter().all(|covered| (930..=985).contains(covered)),
            "{covered:?}"
        );
    }

    #[test]
    fn a_slip_is_found_with_its_size_and_its_moment() {
        for (samples, reading_index) in [(1, 40), (-1, 3), (2, 77), (5, 60), (11, 41)] {
            let mut slipped = readings(1.1, 0.3 / RATE_HZ, 1e-5, 7);
            for reading in &mut slipped[reading_index..] {
                let late = TAU * reading.frequency_hz * f64::from(samples) / RATE_HZ;
                reading.ratio *= Complex64::cis(-late);
            }
            let slip = find_slip(&slipped, CARRIER_HZ, RATE_HZ);
            assert_eq!(
                slip,
                Some(SampleSlip {
                    samples,
                    reading: reading_index
                })
            );
        }
        assert_eq!(
            find_slip(&readings(1.1, 1e-6, 1e-3, 7), CARRIER_HZ, RATE_HZ),
            None
        );
        let mut ragged = readings(1.1, 1e-6, 1e-5, 7);
        for reading in ragged.iter_mut().step_by(3) {
            reading.ratio *= Complex64::cis(0.4);
        }
        assert_eq!(find_slip(&ragged, CARRIER_HZ, RATE_HZ), None);
    }
}
