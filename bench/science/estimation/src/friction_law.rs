//! Friction from the friction ratio of Eq. 19.

use contact::first_order_lag::Lag;
use nalgebra::{Matrix2, Vector2};

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

    /// Returns the law with an error κ of all measured friction added, for a fitted floor.
    pub(super) fn with_offset_error(mut self, offset: f64) -> Self {
        // μ + κ = μ0′ (φ′ + (1 − φ′) r) for all r: μ0′ = μ0 + κ and, to first order, φ′ = φ + κ (1 − φ)/μ0.
        let by_offset = Vector2::new(1.0, (1.0 - self.floor) / self.mu0) * offset;
        self.scatter += by_offset * by_offset.transpose();
        self
    }

    /// Returns μ/μ0 for a ratio by Eq. 19.
    pub(super) fn relative_mu(&self, ratio: f64) -> f64 {
        self.floor + (1.0 - self.floor) * ratio
    }

    /// Returns μ at a time for a ratio by Eq. 19.
    pub(super) fn mu(&self, ratio: f64, time_s: f64) -> f64 {
        self.mu0 * self.course.ratio_at(time_s) * self.relative_mu(ratio)
    }

    /// Returns the standard error of μ0 from the scatter of the measured friction.
    pub(super) fn mu0_scatter(&self) -> f64 {
        self.scatter[(0, 0)].sqrt()
    }
}

/// Friction of an instance as estimated and as modelled.
pub(super) struct SensedFriction<'a> {
    /// Friction estimated at each sample of the instance; NaN where a sample has none.
    pub(super) estimated_mu: &'a [f64],
    /// Friction of the fitted model, with the lead-in.
    pub(super) modelled_mu: &'a [f64],
    /// Normal force, with the lead-in, N.
    pub(super) normal_n: &'a [f64],
    /// Sampling interval, s.
    pub(super) interval_s: f64,
}

impl SensedFriction<'_> {
    /// Returns the estimated friction as a lateral force sensor with a lag would read it. The lateral force μ f_n passes the lag,
    /// and the reading is divided by f_n. The lag starts with the modelled friction of the lead-in, so that its state at the
    /// first sample is settled, and passes a sample without an estimate with the modelled friction.
    pub(super) fn read(&self, lag_s: f64) -> Vec<f64> {
        if lag_s == 0.0 {
            return self.estimated_mu.to_vec();
        }
        let lead = self.modelled_mu.len() - self.estimated_mu.len();
        let unknown_lead = std::iter::repeat_n(&f64::NAN, lead);
        let estimated_mu = unknown_lead.chain(self.estimated_mu);
        let rows = estimated_mu.zip(self.modelled_mu).zip(self.normal_n);
        let lateral_n: Vec<f64> = rows
            .map(|((estimated, modelled), n)| {
                let mu = if estimated.is_finite() {
                    estimated
                } else {
                    modelled
                };
                mu * n
            })
            .collect();
        let mut output_n = vec![0.0; lateral_n.len()];
        Lag::new(lag_s, self.interval_s).apply(&lateral_n, &mut output_n);
        let readings = output_n.iter().zip(self.normal_n).skip(lead);
        readings
            .zip(self.estimated_mu)
            .map(|((output_n, n), mu)| {
                if mu.is_finite() {
                    output_n / n
                } else {
                    f64::NAN
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAD: usize = 40;
    const LAG_S: f64 = 2e-3;

    /// A line, which a lag of four samples reads four samples late.
    fn line() -> Vec<f64> {
        (0..100).map(|n| 0.8 - 0.002 * f64::from(n)).collect()
    }

    fn reading(modelled_mu: &[f64], estimated_mu: &[f64], lag_s: f64) -> Vec<f64> {
        let friction = SensedFriction {
            estimated_mu,
            modelled_mu,
            normal_n: &vec![0.6; modelled_mu.len()],
            interval_s: 5e-4,
        };
        friction.read(lag_s)
    }

    #[test]
    fn a_sample_without_friction_affects_no_other() {
        let line = line();
        let mut interrupted_mu = line[LEAD..].to_vec();
        for sample in [0, 20, 23, 40] {
            interrupted_mu[sample] = f64::NAN;
        }
        let interrupted_reading = reading(&line, &interrupted_mu, LAG_S);
        for (sample, mu) in interrupted_mu.iter().enumerate() {
            let read_mu = interrupted_reading[sample];
            assert_eq!(read_mu.is_nan(), mu.is_nan(), "{sample}");
            assert!(
                mu.is_nan() || (read_mu - (mu + 0.008)).abs() < 1e-9,
                "{sample}"
            );
        }
        assert_eq!(reading(&line, &line[LEAD..], 0.0), line[LEAD..]);
    }

    /// The slope of the first estimated samples, which have noise, does not set the state of the lag.
    #[test]
    fn noise_of_the_first_samples_is_not_extrapolated() {
        let line = line();
        let mut noisy_mu = line[LEAD..].to_vec();
        for (mu, noise) in noisy_mu.iter_mut().zip([0.02, -0.02, 0.02]) {
            *mu += noise;
        }
        let noisy_reading = reading(&line, &noisy_mu, LAG_S);
        for (read_mu, mu) in noisy_reading.iter().zip(&line[LEAD..]) {
            assert!((read_mu - (mu + 0.008)).abs() < 0.01, "{read_mu} {mu}");
        }
    }
}
