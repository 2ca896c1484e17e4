//! Periodic part of a slow signal, such as an envelope.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// A sinusoid that dominates the changes of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Periodicity {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude relative to the mean.
    pub index: f64,
    /// Phase in the middle of the values, rad.
    pub phase_rad: f64,
}

/// Fewest periods that are told from a drift.
const FEWEST_PERIODS: usize = 3;
/// Least share of the sinusoid's power in all changes faster than a drift.
const LEAST_SHARE: f64 = 0.3;
/// Least amplitude relative to the mean.
const LEAST_INDEX: f64 = 0.02;
/// Fewest values in which a period is sought.
const FEWEST_VALUES: usize = 32;

impl Periodicity {
    /// Returns the delay of this envelope after another one, between half a period early and half a period late; `None` for
    /// another frequency.
    pub fn delay_s(&self, other: &Self) -> Option<f64> {
        let is_same = (self.frequency_hz / other.frequency_hz - 1.0).abs() < 0.02;
        let angle = statistics::wrap_rad(other.phase_rad - self.phase_rad);
        is_same.then_some(angle / (TAU * self.frequency_hz))
    }
}

/// Finds the sinusoid that dominates the changes of `values`, taken every `interval_s`.
pub(crate) fn periodicity(values: &[f64], interval_s: f64) -> Option<Periodicity> {
    let n = values.len();
    if n < FEWEST_VALUES {
        return None;
    }
    let window: Vec<f64> = fourier::hann(n).collect();
    let weight: f64 = window.iter().sum();
    let mean = values.iter().zip(&window).map(|(x, w)| x * w).sum::<f64>() / weight;
    let transform = fourier::forward(n);
    let (mut input, mut bins) = (transform.make_input_vec(), transform.make_output_vec());
    for ((slot, x), w) in input.iter_mut().zip(values).zip(&window) {
        *slot = (x - mean) * w;
    }
    transform.process(&mut input, &mut bins).ok()?;
    let powers: Vec<f64> = bins.iter().map(Complex64::norm_sqr).collect();
    let candidates = FEWEST_PERIODS..powers.len().saturating_sub(2);
    let peak = candidates
        .clone()
        .max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
    let total: f64 = powers[FEWEST_PERIODS..].iter().sum();
    let near: f64 = powers[peak - 2..=peak + 2].iter().sum();
    // The first bin belongs to a drift that only falls towards it.
    let is_drift = peak == FEWEST_PERIODS && powers[peak - 1] > powers[peak];
    if is_drift || near < LEAST_SHARE * total {
        return None;
    }
    // The logarithm of a Hann window's main lobe is nearly a parabola.
    let [left, middle, right] =
        [-1, 0, 1].map(|d: isize| powers[peak.saturating_add_signed(d)].max(1e-300).ln());
    let curvature = left - 2.0 * middle + right;
    let shift = if curvature < 0.0 {
        0.5 * (left - right) / curvature
    } else {
        0.0
    };
    let cycles = (peak as f64 + shift.clamp(-0.5, 0.5)) / n as f64;
    let sum: Complex64 = (values.iter().zip(&window).enumerate())
        .map(|(i, (x, w))| {
            Complex64::from_polar((x - mean) * w, -TAU * cycles * (i as f64 - 0.5 * n as f64))
        })
        .sum();
    let index = 2.0 * sum.norm() / weight / mean.abs();
    (index > LEAST_INDEX).then_some(Periodicity {
        frequency_hz: cycles / interval_s,
        index,
        phase_rad: sum.arg(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sinusoid_is_found_with_its_index_and_phase() {
        let values: Vec<f64> = (0..1_500)
            .map(|n| 3.0 * (1.0 + 0.8 * (TAU * 6.3 * f64::from(n) * 1e-3 + 0.7).cos()))
            .collect();
        let found = periodicity(&values, 1e-3).unwrap();
        assert!((found.frequency_hz - 6.3).abs() < 0.03, "{found:?}");
        assert!((found.index - 0.8).abs() < 0.01, "{found:?}");
        let phase_rad = statistics::wrap_rad(TAU * 6.3 * 0.75 + 0.7 - found.phase_rad);
        assert!(phase_rad.abs() < 0.01, "{found:?}");
    }

    #[test]
    fn drift_step_and_constant_have_no_period() {
        let drift: Vec<f64> = (0..500).map(|n| 1.0 + 0.01 * f64::from(n)).collect();
        assert_eq!(periodicity(&drift, 1.0), None);
        let step: Vec<f64> = (0..500).map(|n| 1.0 + f64::from(n >= 200)).collect();
        assert_eq!(periodicity(&step, 1.0), None);
        assert_eq!(periodicity(&[1.0; 500], 1.0), None);
        assert_eq!(periodicity(&[], 1.0), None);
    }
}
