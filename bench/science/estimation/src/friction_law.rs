//! Friction from the friction ratio of Eq. 19.

use crate::first_order_lag::Lag;
use nalgebra::Matrix2;

/// Change of μ0 within an instance, for example because the skin grows moist or the slide slows down.
#[derive(Clone, Copy, Default)]
pub(super) struct Course {
    /// Relative rate, 1/s.
    pub(super) per_s: f64,
    /// Time of the middle of the instance, s.
    pub(super) middle_s: f64,
}

impl Course {
    /// Returns μ0 relative to its value at the middle.
    pub(super) fn ratio_at(&self, time_s: f64) -> f64 {
        1.0 + self.per_s * (time_s - self.middle_s)
    }
}

/// μ = μ0 (φ + (1 − φ) e^(−(x − x_t⁰)/σ_t)): Huloux 2021, Eq. 19, with an added floor φ.
#[derive(Clone, Copy)]
pub(super) struct FrictionLaw<const N: usize> {
    /// μ0 at the middle of the instance.
    pub(super) mu0: f64,
    /// Change of μ0 within the instance.
    pub(super) course: Course,
    /// φ, 0 where friction is assumed to vanish with the contact.
    pub(super) floor: f64,
    /// Lag of the lateral force, s; 0 where it is assumed to have no lag.
    pub(super) lag_s: f64,
    /// ∂μ0/∂parameter.
    pub(super) slopes: [f64; N],
    /// ∂φ/∂parameter.
    pub(super) floor_slopes: [f64; N],
    /// Covariance of μ0 and φ that the parameters do not explain, including the scatter of the measured friction.
    pub(super) scatter: Matrix2<f64>,
}

impl<const N: usize> FrictionLaw<N> {
    /// Returns Eq. 19 as published, with the standard error of μ0 from the scatter of the measured friction.
    pub(super) fn paper(mu0: f64, mu0_std: f64, slopes: [f64; N]) -> Self {
        Self {
            mu0,
            course: Course::default(),
            floor: 0.0,
            lag_s: 0.0,
            slopes,
            floor_slopes: [0.0; N],
            scatter: Matrix2::new(mu0_std * mu0_std, 0.0, 0.0, 0.0),
        }
    }

    /// Returns the law with a relative error of the lateral force added.
    pub(super) fn with_lateral_error(mut self, relative: f64) -> Self {
        self.scatter[(0, 0)] += (self.mu0 * relative).powi(2);
        self
    }

    /// Returns μ/μ0 for a ratio by Eq. 19.
    pub(super) fn relative_mu(&self, ratio: f64) -> f64 {
        self.floor + (1.0 - self.floor) * ratio
    }

    /// Returns the standard error of μ0 from the scatter of the measured friction.
    pub(super) fn mu0_scatter(&self) -> f64 {
        self.scatter[(0, 0)].sqrt()
    }
}

/// Fewest samples needed to start a lag.
const MIN_SAMPLES: usize = 4;

/// Returns a friction as a lateral force sensor with a lag would read it. Each stretch of samples with friction is filtered
/// separately; a stretch too short to filter is returned unchanged. The lateral force μ f_n passes the lag, and the reading is
/// divided by f_n.
pub(super) fn sensor_friction(
    mu: &[f64],
    normal_n: &[f64],
    lag_s: f64,
    interval_s: f64,
) -> Vec<f64> {
    let mut reading = mu.to_vec();
    if lag_s == 0.0 {
        return reading;
    }
    let lag = Lag::new(lag_s, interval_s);
    let mut start = 0;
    for stretch in mu.split(|mu| !mu.is_finite()) {
        let range = start..start + stretch.len();
        start = range.end + 1;
        if stretch.len() < MIN_SAMPLES {
            continue;
        }
        let normal_n = &normal_n[range.clone()];
        let lateral: Vec<f64> = stretch.iter().zip(normal_n).map(|(mu, n)| mu * n).collect();
        let mut output = vec![0.0; lateral.len()];
        lag.apply(&lateral, &mut output);
        for ((reading, output), n) in reading[range].iter_mut().zip(output).zip(normal_n) {
            *reading = output / n;
        }
    }
    reading
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_without_friction_affects_no_other() {
        let line: Vec<f64> = (0..60).map(|n| 0.8 + 0.002 * f64::from(n)).collect();
        let normal_n = vec![0.6; line.len()];
        let reading = |mu: &[f64]| sensor_friction(mu, &normal_n, 2e-3, 5e-4);
        let mut interrupted_line = line.clone();
        for sample in [0, 20, 23, 40] {
            interrupted_line[sample] = f64::NAN;
        }
        // On a straight line each stretch is read alike, four samples late; a stretch of two samples is left unchanged.
        let (line_reading, interrupted_reading) = (reading(&line), reading(&interrupted_line));
        for (sample, mu) in interrupted_line.iter().enumerate() {
            let expected = match sample {
                21 | 22 => line[sample],
                _ => line_reading[sample],
            };
            assert_eq!(
                interrupted_reading[sample].is_nan(),
                mu.is_nan(),
                "{sample}"
            );
            assert!(
                mu.is_nan() || (interrupted_reading[sample] - expected).abs() < 1e-9,
                "{sample}"
            );
            assert!(
                (line_reading[sample] - (line[sample] - 0.008)).abs() < 1e-9,
                "{sample}"
            );
        }
        assert_eq!(sensor_friction(&line, &normal_n, 0.0, 5e-4), line);
    }
}
