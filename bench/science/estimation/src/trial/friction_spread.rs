//! Uncertainty of μ0 and φ due to the contact fitted before them.
//!
//! φ and the lag are fitted to all instances, so they depend on every contact of the trial; μ0 of an instance depends on its
//! own contact and on those two. Where a modelled ratio that is too high would lower μ0, φ changes first.
//!
//! With θ_i the model's parameters at instance i, p = (φ, lag), T_i = ∂p/∂θ_i and R_i the response of θ_i to calibration
//! errors,
//!
//! ```text
//! δp = Σ_i T_i δθ_i,   Cov p = Σ_ij T_i Cov(θ_i, θ_j) T_jᵀ,   Cov(θ_i, p) = Σ_j Cov(θ_i, θ_j) T_jᵀ
//! ```
//!
//! where Cov(θ_i, θ_j) = (noise of the fit) + R_i R_jᵀ. δp splits into its regression on one instance, B_iᵀδθ_i with
//! B_i = Cov(θ_i)⁺Cov(θ_i, p), and a remainder uncorrelated with it, of covariance Cov p − Cov(p, θ_i) B_i. So
//!
//! ```text
//! δφ = (B_iᵀδθ_i)_φ + remainder,   δμ0 = (∂μ0/∂θ_i) δθ_i + (∂μ0/∂p)(B_iᵀδθ_i + remainder)
//! ```

use nalgebra::{Matrix2, SMatrix, SVector};

use super::friction::{FRICTION_PARAMETERS, FrictionParameter, SharedFriction, TrialFriction};
use super::layout::{Own, Shared};
use super::members::{Covariance, ParameterSlopes, Step, TrialMinimum};
use crate::friction_law::FrictionLaw;
use contact::calibration_errors::{ByError, ERRORS};
use contact::parameters::{MS, PARAMETERS};
use contact::uncertain::Uncertain;

pub(super) type ParameterCovariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Covariances of φ and the lag due to the contacts of a trial.
pub(super) struct FrictionSpread {
    /// Covariance of φ and the lag from that of the contacts.
    trial: Matrix2<f64>,
    /// Covariance of the model's parameters at each instance with φ and the lag.
    cross: Vec<SMatrix<f64, PARAMETERS, FRICTION_PARAMETERS>>,
}

impl FrictionSpread {
    /// Returns the spread for the covariance of a minimum; `None` if the normal matrix is singular.
    pub(super) fn new(
        friction: &TrialFriction,
        parameter_slopes: &[ParameterSlopes],
        minimum: &TrialMinimum,
        covariance: &Covariance,
        by_error: &ByError<PARAMETERS>,
    ) -> Option<Self> {
        let instances = || friction.instances.iter().zip(parameter_slopes);
        let mut by_errors = SMatrix::<f64, FRICTION_PARAMETERS, ERRORS>::zeros();
        for (index, (instance, slopes)) in instances().enumerate() {
            by_errors += instance.trial_by_contact * slopes.response(covariance, index, by_error);
        }
        let combinations: [Step; FRICTION_PARAMETERS] = std::array::from_fn(|row| {
            let mut combination = Step {
                shared: Shared::zeros(),
                own: Vec::with_capacity(parameter_slopes.len()),
            };
            for (instance, slopes) in instances() {
                let by_contact = instance.trial_by_contact.row(row);
                let own_combination: Own = slopes.by_own.tr_mul(&by_contact.transpose());
                combination.own.push(own_combination);
                combination.shared += slopes.by_shared.tr_mul(&by_contact.transpose());
            }
            combination
        });
        // With δθ_i = O_i δo_i + S_i δs, row k of δp is the combination Σ_i T_ik O_i δo_i + (Σ_i T_ik S_i) δs.
        let mut combination_covariances = Vec::with_capacity(FRICTION_PARAMETERS);
        for combination in &combinations {
            combination_covariances.push(minimum.combination_covariance(covariance, combination)?);
        }
        let noise_covariance =
            Matrix2::from_fn(|row, column| combinations[row].dot(&combination_covariances[column]));
        let cross = parameter_slopes.iter().enumerate().map(|(index, slopes)| {
            let error_cross = slopes.response(covariance, index, by_error) * by_errors.transpose();
            let mut instance_cross = error_cross;
            for (column, place) in combination_covariances.iter().enumerate() {
                let fit_cross = slopes.by_own * place.own[index] + slopes.by_shared * place.shared;
                instance_cross.set_column(column, &(instance_cross.column(column) + fit_cross));
            }
            instance_cross
        });
        Some(Self {
            trial: noise_covariance + by_errors * by_errors.transpose(),
            cross: cross.collect(),
        })
    }

    /// Returns φ and the lag with errors that combine the scatter of the measured friction with the contacts' errors.
    pub(super) fn widen(&self, friction: SharedFriction) -> SharedFriction {
        let contact_std =
            |parameter: FrictionParameter| self.trial.diagonal()[parameter].max(0.0).sqrt();
        let widen = |estimate: Uncertain, contact_std: f64| Uncertain {
            std: estimate.std.hypot(contact_std),
            ..estimate
        };
        SharedFriction {
            floor: widen(friction.floor, contact_std(FrictionParameter::Floor)),
            lag_s: widen(friction.lag_s, contact_std(FrictionParameter::LagMs) * MS),
        }
    }

    /// Returns an instance's friction law: the dependence of φ and the lag on its parameters as slopes, and the remaining
    /// variance as scatter.
    pub(super) fn law(
        &self,
        friction: &TrialFriction,
        index: usize,
        covariance: &ParameterCovariance,
    ) -> FrictionLaw<PARAMETERS> {
        let instance = &friction.instances[index];
        let cross = self.cross[index];
        let slopes = regression(covariance, &cross);
        let remainder = self.trial - cross.tr_mul(&slopes);
        let mut law = friction.law(index);
        let by_trial = Matrix2::new(
            instance.by_trial[FrictionParameter::Floor],
            instance.by_trial[FrictionParameter::LagMs],
            1.0,
            0.0,
        );
        law.slopes = (instance.by_contact + slopes * instance.by_trial).into();
        law.floor_slopes = slopes
            .column(FrictionParameter::Floor as usize)
            .into_owned()
            .into();
        law.scatter += by_trial * remainder * by_trial.transpose();
        law
    }
}

/// Variance below which a direction of parameters, scaled to unit variance, is rounding.
const ROUNDING: f64 = 1e-10;

/// Returns the regression slopes, on parameters with this covariance, of quantities with covariance `cross` to them.
fn regression(
    covariance: &ParameterCovariance,
    cross: &SMatrix<f64, PARAMETERS, FRICTION_PARAMETERS>,
) -> SMatrix<f64, PARAMETERS, FRICTION_PARAMETERS> {
    // C⁺ = D Q Λ⁺ Qᵀ D with D C D = Q Λ Qᵀ, D = diag(1/√C_jj): parameters without variance or dependent on others drop out.
    let scale: SVector<f64, PARAMETERS> = covariance.diagonal().map(|variance| {
        if variance > 0.0 {
            variance.sqrt().recip()
        } else {
            0.0
        }
    });
    let scale = SMatrix::from_diagonal(&scale);
    let directions = (scale * covariance * scale).symmetric_eigen();
    let inverse = directions.eigenvalues.map(|eigenvalue| {
        if eigenvalue > ROUNDING {
            eigenvalue.recip()
        } else {
            0.0
        }
    });
    let (vectors, inverse) = (directions.eigenvectors, SMatrix::from_diagonal(&inverse));
    scale * vectors * inverse * vectors.transpose() * scale * cross
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With some exact parameters and one that is the sum of two others, the slopes still reproduce the covariance.
    #[test]
    fn slopes_reproduce_the_covariance() {
        let factor = ParameterCovariance::from_fn(|row, column| match (row, column) {
            (0..6, 0..6) => ((row * 5 + column * 3) % 7) as f64 * 0.1_f64.powi(row as i32),
            _ => 0.0,
        });
        let mut covariance = factor * factor.transpose();
        let sum = covariance.row(1) + covariance.row(2);
        covariance.set_row(6, &sum);
        let sum = covariance.column(1) + covariance.column(2);
        covariance.set_column(6, &sum);
        let slopes = SMatrix::<f64, PARAMETERS, FRICTION_PARAMETERS>::from_fn(|row, column| {
            0.3 * row as f64 - column as f64
        });
        let cross = covariance * slopes;
        let product = covariance * regression(&covariance, &cross);
        let scale = covariance.diagonal().map(f64::sqrt);
        for (row, scale) in scale.iter().enumerate() {
            for column in 0..FRICTION_PARAMETERS {
                let difference = (product[(row, column)] - cross[(row, column)]).abs();
                assert!(difference <= 1e-6 * scale, "{row}: {difference} of {scale}");
            }
        }
    }
}
