//! Zero-phase filter for a noisy force sensor: it passes at each frequency the finger's fraction of the power.
//!
//! σ_t and τ are estimated from the response of the gap to the normal force. Noise taken for force biases them, and so does
//! force taken for noise (τ is read 0.1 ms short). The sensor's noise is estimated from the record: its white noise alone
//! remains in the upper part of the band. Below, H(f) = 1 − 1.2 N/P(f) (after Wiener 1949), with the record's own
//! spectrum P.
//!
//! The reading is y = f + n with the power P = F + N. The filter H that minimises ⟨|H y − f|²⟩ = (1 − H)² F + H² N at each
//! frequency is H = F/(F + N) = (P − N)/P = 1 − N/P, and 0 where P < N. P is the median over stretches at each frequency,
//! averaged over a range of f·1.25^±1; N is the median of P over the upper band.

use statistics::median;
use std::ops::RangeInclusive;

/// Frequency from which on a record shows only its sensor's noise: a quarter of its band and at least this, Hz; for a slow
/// record, the upper half of the band.
const FLOOR_HZ: f64 = 200.0;
const FLOOR_OF_BAND: f64 = 0.25;
/// Sampling rates of a record, Hz: the upper half of the band lies above a finger's own force, and a force sensor may have
/// them.
const RATES_HZ: RangeInclusive<f64> = 200.0..=1e6;
/// Frequency above which the gain is 0, Hz.
const HIGHEST_HZ: f64 = 500.0;
/// Fraction of the band up to half the rate that is used: above, a sensor's own filter may have removed noise.
const USABLE: f64 = 0.8;
/// Length of the stretches for the spectra, s.
const STRETCH_S: f64 = 0.4;
/// The spectrum at f is the mean from f/WIDTH to f·WIDTH; without averaging, its scatter would let noise through in places.
const WIDTH: f64 = 1.25;
/// Factor on the noise that is subtracted: the spectrum scatters, and passing noise costs more than losing force
/// (Berouti, Schwartz & Makhoul 1979).
const OVER: f64 = 1.2;
/// Frequency above which the gain never rises: aim and tremor, with peaks in their spectrum, are slower than this.
const FALLING_HZ: f64 = 15.0;

/// Returns the filtered values of an evenly sampled record at `rate_hz`, with `finer` output values for each; `None` if its
/// rate or length does not reveal the noise.
///
/// ```
/// let press_n = |i: usize| 0.6 + 0.02 * (i as f64 / 160.0).sin();
/// // A sensor that is off by 2 mN one way and the other.
/// let read_n: Vec<f64> = (0..4000).map(|i| press_n(i) + if i % 2 == 0 { 2e-3 } else { -2e-3 }).collect();
/// let force_n = impedance::wiener::filtered(&read_n, 2000.0, 1).expect("long and fast enough");
/// assert!((force_n[2000] - press_n(2000)).abs() < 2e-4);
/// ```
pub fn filtered(values: &[f64], rate_hz: f64, finer: usize) -> Option<Vec<f64>> {
    if !RATES_HZ.contains(&rate_hz) {
        return None;
    }
    let stretch = (STRETCH_S * rate_hz).round() as usize;
    if values.len() < 2 * stretch {
        return None;
    }
    let spectrum = Spectrum::estimate(values, rate_hz, stretch)?;
    let noise = spectrum.noise()?;
    let passes = spectrum.passes(noise);
    multiplied(values, rate_hz, finer, |frequency_hz| {
        let bin = frequency_hz / spectrum.step_hz;
        let lower = (bin as usize).min(passes.len() - 1);
        let upper = (lower + 1).min(passes.len() - 1);
        passes[lower] + (bin - bin.floor()) * (passes[upper] - passes[lower])
    })
}

/// Median power of Hann-windowed stretches that overlap by half (after Welch 1967), in a common unit.
struct Spectrum {
    step_hz: f64,
    power: Vec<f64>,
}

impl Spectrum {
    fn estimate(values: &[f64], rate_hz: f64, stretch: usize) -> Option<Self> {
        let forward = fourier::forward(stretch);
        let mut spectrum = forward.make_output_vec();
        let mut powers = vec![Vec::new(); spectrum.len()];
        for start in (0..=values.len() - stretch).step_by(stretch / 2) {
            let piece = &values[start..start + stretch];
            let (slope, middle) = line_through(piece);
            let mut windowed: Vec<f64> = piece
                .iter()
                .enumerate()
                .map(|(i, value)| {
                    let turn = std::f64::consts::TAU * (i as f64 + 0.5) / stretch as f64;
                    let straight = middle + slope * (i as f64 - 0.5 * (stretch - 1) as f64);
                    (value - straight) * 0.5 * (1.0 - turn.cos())
                })
                .collect();
            forward.process(&mut windowed, &mut spectrum).ok()?;
            for (powers, bin) in powers.iter_mut().zip(&spectrum) {
                powers.push(bin.norm_sqr());
            }
        }
        // A touch or a lift-off contains all frequencies at once, and would bias a mean.
        let power = powers.into_iter().map(median).collect::<Option<_>>()?;
        Some(Self {
            step_hz: rate_hz / stretch as f64,
            power,
        })
    }

    fn bin(&self, frequency_hz: f64) -> usize {
        ((frequency_hz / self.step_hz).round() as usize).min(self.power.len() - 1)
    }

    fn mean(&self, from_hz: f64, to_hz: f64) -> f64 {
        let band = &self.power[self.bin(from_hz)..=self.bin(to_hz)];
        band.iter().sum::<f64>() / band.len() as f64
    }

    /// Returns the power of the sensor's noise in a bin; `None` without any, as in a simulation.
    fn noise(&self) -> Option<f64> {
        let nyquist_hz = self.step_hz * (self.power.len() - 1) as f64;
        let floor_hz = FLOOR_HZ
            .max(FLOOR_OF_BAND * nyquist_hz)
            .min(nyquist_hz / 2.0);
        let mut band = self.power[self.bin(floor_hz)..=self.bin(USABLE * nyquist_hz)].to_vec();
        band.sort_by(f64::total_cmp);
        // Hum would bias the mean; the median of averaged power is close enough to it.
        band.get(band.len() / 2)
            .copied()
            .filter(|noise| *noise > 0.0)
    }

    /// Returns the gain of each bin.
    fn passes(&self, noise: f64) -> Vec<f64> {
        let mut least: f64 = 1.0;
        (0..self.power.len())
            .map(|bin| {
                let frequency_hz = bin as f64 * self.step_hz;
                if frequency_hz > HIGHEST_HZ {
                    return 0.0;
                }
                let power = self.mean(frequency_hz / WIDTH, frequency_hz * WIDTH);
                let passes = (1.0 - OVER * noise / power).max(0.0);
                if frequency_hz < FALLING_HZ {
                    return passes;
                }
                least = least.min(passes);
                least
            })
            .collect()
    }
}

/// Returns slope per sample and mean of the least-squares line through values.
fn line_through(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let offset = i as f64 - 0.5 * (n - 1.0);
        covariance += offset * (value - mean);
        variance += offset * offset;
    }
    (covariance / variance, mean)
}

/// Multiplies the spectrum of a record, extended by its mirror image so that its ends meet, and returns it on a finer grid.
fn multiplied(
    values: &[f64],
    rate_hz: f64,
    finer: usize,
    passes: impl Fn(f64) -> f64,
) -> Option<Vec<f64>> {
    let n = values.len();
    let mut mirrored: Vec<f64> = values.iter().chain(values.iter().rev()).copied().collect();
    let (forward, inverse) = (fourier::forward(2 * n), fourier::inverse(2 * n * finer));
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut mirrored, &mut spectrum).ok()?;
    let step_hz = rate_hz / (2 * n) as f64;
    for (bin, value) in spectrum.iter_mut().enumerate() {
        // The mean and components slower than a stretch belong to the finger.
        let part = if bin == 0 {
            1.0
        } else {
            passes(bin as f64 * step_hz)
        };
        // The inverse transform of the planner is not normalised: 1/(2n) for any number of output values.
        *value *= part / (2 * n) as f64;
    }
    // The component at half the old rate would appear twice.
    let mut fine = inverse.make_input_vec();
    let below_half = n.min(fine.len());
    fine[..below_half].copy_from_slice(&spectrum[..below_half]);
    let mut filtered = inverse.make_output_vec();
    inverse.process(&mut fine, &mut filtered).ok()?;
    filtered.truncate(n * finer);
    Some(filtered)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Returns a finger's force: aim, tremor, and a wander in which every octave has a quarter of the power of the one below.
    fn force(rate_hz: f64, seconds: f64, wander_n: f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (mut wander, time_s) = (0.0, 1.0);
        let carry = (-1.0 / rate_hz / time_s).exp();
        (0..(rate_hz * seconds) as usize)
            .map(|i| i as f64 / rate_hz)
            .map(|t| {
                let white: f64 = StandardNormal.sample(&mut random);
                wander = carry * wander + wander_n * (1.0 - carry * carry).sqrt() * white;
                0.65 + 0.05 * t + 0.02 * (TAU * 9.3 * t).sin() + wander
            })
            .collect()
    }

    fn noisy(force: &[f64], noise_n: f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let mut white = || -> f64 { StandardNormal.sample(&mut random) };
        force.iter().map(|n| n + noise_n * white()).collect()
    }

    /// Returns the RMS of the remaining noise and the missing force, away from the ends.
    fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
        let edge = a.len() / 20;
        let inside = edge..a.len() - edge;
        let squares: f64 = inside.clone().map(|i| (a[i] - b[i]).powi(2)).sum();
        (squares / inside.len() as f64).sqrt()
    }

    #[test]
    fn a_smooth_force_loses_the_sensors_noise() {
        for rate_hz in [1000.0, 2500.0, 10_000.0] {
            let smooth = force(rate_hz, 1.7, 0.0);
            let noise_n = 3e-3 * (rate_hz / 10_000.0).sqrt();
            let filtered = filtered(&noisy(&smooth, noise_n), rate_hz, 1).unwrap();
            let left_n = rms_difference(&filtered, &smooth);
            // A low-pass of 100 Hz leaves a tenth of 3 mN at 10 kHz, and this filter at most two thirds of that.
            let of_low_pass_n = noise_n * (200.0 / rate_hz).sqrt();
            assert!(left_n < 0.65 * of_low_pass_n, "{rate_hz}: {left_n}");
        }
    }

    #[test]
    fn a_wander_that_stands_out_of_the_noise_is_kept() {
        let wandering = force(10_000.0, 1.7, 0.03);
        let filtered = filtered(&noisy(&wandering, 2e-3), 10_000.0, 1).unwrap();
        let rms_n = rms_difference(&filtered, &wandering);
        assert!(rms_n < 0.75e-3, "{rms_n}");
        let clean = super::filtered(&wandering, 10_000.0, 1).unwrap();
        let rms_n = rms_difference(&clean, &wandering);
        assert!(rms_n < 0.6e-3, "{rms_n}");
    }

    #[test]
    fn a_record_that_does_not_show_its_noise_is_not_filtered() {
        let is_refused = |rate_hz: f64, seconds: f64| {
            filtered(&force(rate_hz, seconds, 0.01), rate_hz, 1).is_none()
        };
        assert!(is_refused(150.0, 3.0), "too slow");
        for rate_hz in [f64::INFINITY, f64::NAN, -1.0] {
            assert_eq!(
                filtered(&[0.5, 0.6], rate_hz, 1),
                None,
                "all rows at one time"
            );
        }
        assert!(is_refused(2000.0, 0.7), "too short");
        assert_eq!(filtered(&[0.5; 4000], 2000.0, 1), None, "no noise at all");
    }

    /// The ends meet their mirror images; ringing there decays within the margin that is read beyond an exploration.
    #[test]
    fn a_slow_record_is_given_on_a_finer_grid() {
        let (slow_hz, finer) = (250.0, 8);
        let truth = |t: f64| 0.65 + 0.05 * t + 0.02 * (TAU * 9.3 * t).sin();
        let rows: Vec<f64> = (0..500).map(|i| truth(f64::from(i) / slow_hz)).collect();
        let fine = filtered(&noisy(&rows, 5e-4), slow_hz, finer).unwrap();
        assert_eq!(fine.len(), rows.len() * finer);
        let margin = 200;
        for (i, force) in fine
            .iter()
            .enumerate()
            .skip(margin)
            .take(fine.len() - 2 * margin)
        {
            let expected = truth(i as f64 / slow_hz / finer as f64);
            assert!((force - expected).abs() < 1.5e-3, "{i}: {force} {expected}");
        }
    }
}
