//! Modulation of the drive's amplitude: frequency and index.

use std::f64::consts::{SQRT_2, TAU};

use num_complex::Complex64;
use statistics::significant;

/// Frequencies of a modulation, Hz.
const RANGE_HZ: (f64, f64) = (0.2, 500.0);
/// Index below which the drive counts as not modulated.
const LEAST_INDEX: f64 = 0.005;
/// Share of the amplitude's upper decile that its running maximum must exceed while the drive is on.
const ON_SHARE: f64 = 0.7;
/// Shortest time of a drive that shows its modulation, s.
const LEAST_S: f64 = 0.3;

/// Reasons why a drive shows no modulation, not even that it has none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ModulationError {
    /// Every sample is 0.
    #[error("the drive is off: its RMS is 0 V throughout")]
    Off,
    /// The carrier is weaker than all else.
    #[error(
        "the drive is off, or its carrier is at another frequency: in nine tenths of the recording, the carrier's RMS is at most {} V, \
         and that of all else is {} V",
        significant(*carrier_v), significant(*rest_v)
    )]
    BelowNoise {
        /// RMS of the carrier that it has at most in nine tenths of the recording, V.
        carrier_v: f64,
        /// RMS of all else, V.
        rest_v: f64,
    },
    /// The drive is on too briefly.
    #[error(
        "the drive, of {} V RMS, is on for less than {LEAST_S} s at a time, too short to show its modulation",
        significant(*rms_v)
    )]
    Short {
        /// RMS of all samples, V.
        rms_v: f64,
    },
}

/// Modulation of an amplitude, A (1 + index sin(2πft + phase)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundModulation {
    /// Frequency, Hz.
    pub hz: f64,
    /// Its standard error, Hz.
    pub hz_error: f64,
    /// Index.
    pub index: f64,
    /// Its standard error.
    pub index_error: f64,
}

impl FoundModulation {
    /// Returns the modulation of a drive, of which each value of the amplitude is a mean over `step_s`: this lowers a sine by
    /// sin(πfT)/(πfT).
    #[must_use]
    pub fn of_means(self, step_s: f64) -> Self {
        let half_rad = TAU / 2.0 * self.hz * step_s;
        let gain = if half_rad > 0.0 {
            half_rad / half_rad.sin()
        } else {
            1.0
        };
        Self {
            index: self.index * gain,
            index_error: self.index_error * gain,
            ..self
        }
    }
}

/// Longest stretch in which the drive is on with a steady modulation, as indices.
fn steady(amplitude: &[f64], step_s: f64) -> std::ops::Range<usize> {
    let mut sorted: Vec<f64> = amplitude
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let Some(top) = sorted.get(sorted.len() * 9 / 10) else {
        return 0..0;
    };
    // Between the crests of the slowest modulation that is looked for first the amplitude may be low for half a second.
    let reach = (0.5 / step_s) as usize;
    let mut best = 0..0;
    let mut start: Option<usize> = None;
    let mut last_high = None;
    for (index, value) in amplitude.iter().enumerate() {
        if *value > ON_SHARE * top {
            start = start.or(Some(index));
            last_high = Some(index);
        }
        let is_over = last_high.is_some_and(|last| index - last > reach) || !value.is_finite();
        if let (Some(from), Some(last), true) = (start, last_high, is_over) {
            if last - from > best.len() {
                best = from..last;
            }
            (start, last_high) = (None, None);
        }
    }
    if let (Some(from), Some(last)) = (start, last_high)
        && last - from > best.len()
    {
        best = from..last;
    }
    best
}

/// Finds the modulation of a drive as [`find`] does, from its amplitude, V, and the RMS of all its samples, V.
///
/// # Errors
/// The drive is off, or on too briefly.
pub fn require(
    amplitude_v: &[f64],
    step_s: f64,
    rms_v: f64,
) -> Result<FoundModulation, ModulationError> {
    let known = amplitude_v
        .iter()
        .copied()
        .filter(|value| value.is_finite());
    let mut known: Vec<f64> = known.collect();
    known.sort_by(f64::total_cmp);
    let top_v = known.get(known.len() * 9 / 10).copied().unwrap_or(0.0);
    if rms_v == 0.0 || known.last() == Some(&0.0) {
        return Err(ModulationError::Off);
    }
    let square_v2 = known.iter().map(|value| value * value).sum::<f64>() / known.len() as f64;
    let rest_v = (rms_v * rms_v - square_v2 / 2.0).max(0.0).sqrt();
    let carrier_v = top_v / SQRT_2;
    if carrier_v < rest_v {
        return Err(ModulationError::BelowNoise { carrier_v, rest_v });
    }
    find(amplitude_v, step_s).ok_or(ModulationError::Short { rms_v })
}

/// Finds frequency and index of the modulation of a drive from its amplitude at instants `step_s` apart; an index of 0 without
/// modulation, `None` if the drive is on for less than 0.3 s.
#[must_use]
pub fn find(amplitude: &[f64], step_s: f64) -> Option<FoundModulation> {
    let stretch = &amplitude[steady(amplitude, step_s)];
    let length_s = stretch.len() as f64 * step_s;
    if length_s < LEAST_S {
        return None;
    }
    let mean = stretch.iter().sum::<f64>() / stretch.len() as f64;
    let size = (4 * stretch.len()).next_power_of_two();
    let transform = fourier::forward(size);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let window = fourier::hann(stretch.len());
    for ((x, value), weight) in input.iter_mut().zip(stretch).zip(window) {
        *x = weight * (value - mean);
    }
    transform.process(&mut input, &mut output).ok()?;
    let resolution_hz = 1.0 / (step_s * size as f64);
    let bin = |hz: f64| ((hz / resolution_hz) as usize).clamp(1, output.len() - 1);
    let lowest_hz = RANGE_HZ.0.max(1.0 / length_s);
    let peak = (bin(lowest_hz)..bin(RANGE_HZ.1))
        .max_by(|a, b| output[*a].norm_sqr().total_cmp(&output[*b].norm_sqr()))?;
    let mut hz = peak as f64 * resolution_hz;
    // Gauss–Newton on the frequency, with the amplitude of mean, sine and their second harmonics solved for linearly.
    let mut fit = harmonic_fit(stretch, step_s, hz);
    let mut width_hz = 0.5 / length_s;
    for _ in 0..40 {
        let trials =
            [hz - width_hz, hz + width_hz].map(|hz| (hz, harmonic_fit(stretch, step_s, hz)));
        let better = trials
            .into_iter()
            .find(|(trial, candidate)| *trial > 0.0 && candidate.residual < fit.residual);
        match better {
            Some((trial, candidate)) => (hz, fit) = (trial, candidate),
            None => width_hz *= 0.5,
        }
    }
    let index = fit.amplitude / fit.mean;
    if index < LEAST_INDEX {
        return Some(FoundModulation {
            hz: 0.0,
            hz_error: 0.0,
            index: 0.0,
            index_error: LEAST_INDEX,
        });
    }
    // Neighbouring values of the residual are not independent: that of 20 values counts as one.
    let count = (stretch.len() as f64 / 20.0).max(1.0);
    let rms = (fit.residual / stretch.len() as f64).sqrt();
    Some(FoundModulation {
        hz,
        // Rife and Boorstyn 1974: var ω = 12 σ²/(A²/2 · n T²), with σ² of a sample.
        hz_error: (24.0 / count).sqrt() * rms / (fit.amplitude * TAU * length_s),
        index,
        index_error: (2.0 / count).sqrt() * rms / fit.mean,
    })
}

/// Mean and first harmonic of a series.
#[derive(Debug, Clone, Copy)]
pub struct HarmonicFit {
    /// Mean.
    pub mean: f64,
    /// Amplitude of the first harmonic.
    pub amplitude: f64,
    /// Its phase at the first value, rad, of a cosine.
    pub phase_rad: f64,
    /// Sum of the squared residuals.
    pub residual: f64,
}

/// Fits mean, fundamental and second harmonic at a frequency by least squares.
#[must_use]
pub fn harmonic_fit(values: &[f64], step_s: f64, hz: f64) -> HarmonicFit {
    const N: usize = 5;
    let mut matrix = [[0.0; N + 1]; N];
    let mut squares = 0.0;
    let rotation = Complex64::cis(TAU * hz * step_s);
    let mut phasor = Complex64::ONE;
    for value in values {
        let second = phasor * phasor;
        let row = [1.0, phasor.re, phasor.im, second.re, second.im];
        for (line, a) in matrix.iter_mut().zip(row) {
            for (sum, b) in line.iter_mut().zip(row.into_iter().chain([*value])) {
                *sum += a * b;
            }
        }
        squares += value * value;
        phasor *= rotation;
    }
    let right: [f64; N] = matrix.map(|line| line[N]);
    let solution = solve(matrix);
    let fitted: f64 = solution.iter().zip(right).map(|(a, b)| a * b).sum();
    let harmonic = Complex64::new(solution[1], -solution[2]);
    HarmonicFit {
        mean: solution[0],
        amplitude: harmonic.norm(),
        phase_rad: harmonic.arg(),
        residual: (squares - fitted).max(0.0),
    }
}

/// Solves a small system of equations by elimination with pivots; 0 for an unknown that it does not determine.
fn solve<const N: usize, const M: usize>(mut matrix: [[f64; M]; N]) -> [f64; N] {
    for column in 0..N {
        let pivot = (column..N).max_by(|a, b| {
            matrix[*a][column]
                .abs()
                .total_cmp(&matrix[*b][column].abs())
        });
        matrix.swap(column, pivot.unwrap_or(column));
        let head = matrix[column];
        if head[column] == 0.0 {
            continue;
        }
        for (index, line) in matrix.iter_mut().enumerate() {
            if index != column {
                let factor = line[column] / head[column];
                for (value, above) in line.iter_mut().zip(head) {
                    *value -= factor * above;
                }
            }
        }
    }
    std::array::from_fn(|index| match matrix[index][index] {
        0.0 => 0.0,
        pivot => matrix[index][M - 1] / pivot,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.5e-3;

    fn amplitude(hz: f64, index: f64) -> Vec<f64> {
        let times_s = (0..6800).map(|n| f64::from(n) * STEP_S);
        times_s
            .enumerate()
            .map(|(n, t)| {
                let ramp = ((t - 0.1) / 0.1).clamp(0.0, 1.0);
                let ripple = 1e-3 * (n as f64 % 7.0 - 3.0);
                ramp * 8.0 * (1.0 + index * (TAU * hz * t).sin() + ripple)
            })
            .collect()
    }

    #[test]
    fn means_over_the_interval_lower_the_index() {
        let found = find(&amplitude(40.0, 0.1), STEP_S).unwrap();
        let corrected = found.of_means(4e-3);
        let loss = (TAU / 2.0 * 40.0 * 4e-3).sin() / (TAU / 2.0 * 40.0 * 4e-3);
        assert!(
            (corrected.index * loss - found.index).abs() < 1e-3,
            "{corrected:?}"
        );
        assert_eq!(
            find(&amplitude(6.0, 0.0), STEP_S)
                .unwrap()
                .of_means(4e-3)
                .index,
            0.0
        );
    }

    #[test]
    fn a_drive_that_is_off_or_on_too_briefly_is_named() {
        let driven = amplitude(6.0, 0.95);
        let rms_v = |amplitude: &[f64]| {
            let squares: f64 = amplitude.iter().map(|a| a * a / 2.0).sum();
            (squares / amplitude.len() as f64).sqrt()
        };
        assert_eq!(
            require(&driven, STEP_S, rms_v(&driven)),
            Ok(find(&driven, STEP_S).unwrap())
        );
        let off = vec![0.0; driven.len()];
        assert_eq!(require(&off, STEP_S, 0.0), Err(ModulationError::Off));
        let faint: Vec<f64> = driven.iter().map(|value| 1e-4 * value).collect();
        let error = require(&faint, STEP_S, 0.1).unwrap_err();
        assert!(
            matches!(error, ModulationError::BelowNoise { rest_v, .. } if (rest_v - 0.1).abs() < 1e-3),
            "{error}"
        );
        let brief = &driven[400..900];
        let error = require(brief, STEP_S, rms_v(brief)).unwrap_err();
        assert!(matches!(error, ModulationError::Short { .. }), "{error}");
    }

    #[test]
    fn frequency_and_index_are_found_within_their_errors() {
        for (hz, index) in [(6.0, 0.95), (3.37, 0.5), (40.0, 0.1), (1.5, 0.8)] {
            let found = find(&amplitude(hz, index), STEP_S).unwrap();
            assert!(
                (found.hz - hz).abs() < (5.0 * found.hz_error).max(2e-3 * hz),
                "{hz} {found:?}"
            );
            assert!((found.index - index).abs() < 0.01, "{index} {found:?}");
        }
        assert_eq!(find(&amplitude(6.0, 0.0), STEP_S).unwrap().index, 0.0);
    }
}
