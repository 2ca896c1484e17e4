//! Errors of φ, the lag and every μ0, from the scatter of the measured friction and a random walk of μ0.
//!
//! With J the slopes of all residuals by p = (φ, λ), including the rows of the priors, s² the variance of the residuals times
//! the factor of their correlation, and W_i the covariance due to the walk in instance i,
//!
//! ```text
//! Cov p = s² (JᵀJ)⁻¹ + Σ_i (W_i)_pp
//! ```

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{Matrix2, Matrix3};
use num_complex::Complex64;

use super::instance::InstanceFriction;
use super::problem::FrictionProblem;
use super::{FrictionParameter, RestFriction, SharedFriction};
use crate::least_squares::correlation;
use contact::parameters::MS;
use contact::uncertain::Uncertain;

/// Variances and covariances at a minimum.
pub(super) struct Errors<'a> {
    minimum: &'a FrictionProblem<'a>,
    /// Variance of a residual, times the factor of the correlation.
    variance: f64,
    /// (JᵀJ)⁻¹.
    inverse: Matrix2<f64>,
    /// Covariance of μ0, φ and the lag due to the random walk in each instance.
    walks: Vec<Matrix3<f64>>,
    /// Covariance of φ and the lag.
    covariance: Matrix2<f64>,
}

impl<'a> Errors<'a> {
    /// Computes the errors for a walk that adds `walk_variance` to ln μ0 per sample; `None` if the data determine neither φ nor
    /// the lag.
    pub(super) fn new(
        minimum: &'a FrictionProblem<'a>,
        fits: &[InstanceFriction<'_>],
        walk_variance: f64,
    ) -> Option<Self> {
        let residuals: Vec<Complex64> = fits
            .iter()
            .flat_map(|fit| fit.residuals.iter().map(|&r| r.into()))
            .collect();
        let squares: f64 = residuals.iter().map(Complex64::norm_sqr).sum();
        let variance = squares / minimum.freedom() * correlation(&residuals);
        let jacobian = minimum.jacobian()?;
        let inverse = jacobian.tr_mul(&jacobian).try_inverse()?;
        let walks: Vec<Matrix3<f64>> = fits
            .iter()
            .map(|fit| fit.walk_covariance(&inverse) * walk_variance)
            .collect();
        let trial_block = |walk: &Matrix3<f64>| walk.fixed_view::<2, 2>(1, 1).into_owned();
        let covariance = inverse * variance + walks.iter().map(trial_block).sum::<Matrix2<f64>>();
        Some(Self {
            minimum,
            variance,
            inverse,
            walks,
            covariance,
        })
    }

    /// Returns φ and the lag with their errors.
    pub(super) fn shared(&self) -> SharedFriction {
        let parameters = &self.minimum.parameters;
        let std = |parameter: FrictionParameter| self.covariance.diagonal()[parameter].sqrt();
        SharedFriction {
            floor: Uncertain {
                value: parameters[FrictionParameter::Floor],
                std: std(FrictionParameter::Floor),
            },
            lag_s: Uncertain {
                value: parameters[FrictionParameter::LagMs] * MS,
                std: std(FrictionParameter::LagMs) * MS,
            },
        }
    }

    /// Returns μ0 of each instance with its errors and derivatives.
    pub(super) fn instances(&self, fits: &[InstanceFriction<'_>]) -> Vec<RestFriction> {
        let fits = fits.iter().zip(&self.walks);
        fits.map(|(fit, walk)| self.rest_friction(fit, walk))
            .collect()
    }

    fn rest_friction(&self, fit: &InstanceFriction<'_>, walk: &Matrix3<f64>) -> RestFriction {
        // The variance of μ0 combines its own scatter with that of φ and the lag. For δμ0 = e + dᵀδp with d = ∂μ0/∂p and
        // k = Cov(e, δp), which only the walk has: Var μ0 = Var e + 2 dᵀk + dᵀCov(p) d and Cov(μ0, p) = Cov(p) d + k.
        let mu0_slopes = fit.mu0_slopes;
        let walk_cross = walk.fixed_view::<2, 1>(1, 0);
        let mu0_variance = self.variance / fit.power;
        let total_variance = mu0_variance
            + walk[(0, 0)]
            + 2.0 * mu0_slopes.dot(&walk_cross)
            + mu0_slopes.dot(&(self.covariance * mu0_slopes));
        let cross = (self.covariance * mu0_slopes + walk_cross)[FrictionParameter::Floor];
        let floor_variance = self.covariance.diagonal()[FrictionParameter::Floor];
        let by_contact = fit.contact_slopes(&self.minimum.parameters);
        RestFriction {
            mu0: fit.mu0,
            course: fit.course(),
            mu0_variance,
            scatter: Matrix2::new(total_variance, cross, cross, floor_variance),
            by_trial: mu0_slopes,
            by_contact: by_contact.mu0,
            trial_by_contact: -self.inverse * by_contact.gradient,
        }
    }
}
