//! Uncertainty of μ0 and φ due to the contact fitted before them.
//!
//! φ and the lag are fitted to all instances, so they depend on every contact of the trial; μ0 of an instance depends on its
//! own contact and on those two. Where a modelled ratio that is too high would lower μ0, φ changes first.

use nalgebra::{Matrix2, SMatrix, SVector};

use super::friction::{FLOOR, LAG_MS, OF_TRIAL, TrialFriction};
use super::members::{Covariance, Following, Minimised, Own, Shared, Step};
use crate::friction_law::FrictionLaw;
use contact::calibration_errors::{ByError, ERRORS};
use contact::parameters::{MS, PARAMETERS};

type OfParameters = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Covariances of φ and the lag due to the contacts of a trial.
pub(super) struct FrictionSpread {
    /// Covariance of φ and the lag from that of the contacts.
    of_trial: Matrix2<f64>,
    /// Covariance of the model's parameters at each instance with φ and the lag.
    with_parameters: Vec<SMatrix<f64, PARAMETERS, OF_TRIAL>>,
}

impl FrictionSpread {
    /// Returns the spread for the covariance of a minimum; `None` if the normal matrix is singular.
    pub(super) fn new(
        friction: &TrialFriction,
        following: &[Following],
        minimum: &Minimised,
        covariance: &Covariance,
        by_error: &ByError<PARAMETERS>,
    ) -> Option<Self> {
        let each = || friction.each.iter().zip(following);
        let mut by_errors = SMatrix::<f64, OF_TRIAL, ERRORS>::zeros();
        for (index, (of, follows)) in each().enumerate() {
            by_errors += of.trial_by_contact * follows.response(covariance, index, by_error);
        }
        let combinations: [Step; OF_TRIAL] = std::array::from_fn(|row| {
            let mut combination = Step {
                shared: Shared::zeros(),
                own: Vec::with_capacity(following.len()),
            };
            for (of, follows) in each() {
                let by_contact = of.trial_by_contact.row(row);
                let own: Own = follows.by_own.tr_mul(&by_contact.transpose());
                combination.own.push(own);
                combination.shared += follows.by_shared.tr_mul(&by_contact.transpose());
            }
            combination
        });
        let mut with_all = Vec::with_capacity(OF_TRIAL);
        for combination in &combinations {
            with_all.push(minimum.covariance_with(covariance, combination)?);
        }
        let of_noise = Matrix2::from_fn(|row, column| combinations[row].dot(&with_all[column]));
        let with_parameters = following.iter().enumerate().map(|(index, follows)| {
            let of_errors = follows.response(covariance, index, by_error) * by_errors.transpose();
            let mut with = of_errors;
            for (column, place) in with_all.iter().enumerate() {
                let moved = follows.by_own * place.own[index] + follows.by_shared * place.shared;
                with.set_column(column, &(with.column(column) + moved));
            }
            with
        });
        Some(Self {
            of_trial: of_noise + by_errors * by_errors.transpose(),
            with_parameters: with_parameters.collect(),
        })
    }

    /// Returns the standard deviations of φ and of the lag in s, combined with those from the scatter of the measured friction.
    pub(super) fn stds(&self, scatter: [f64; OF_TRIAL]) -> [f64; OF_TRIAL] {
        let unit = [1.0, MS];
        std::array::from_fn(|at| {
            let of_contact = self.of_trial[(at, at)].max(0.0).sqrt() * unit[at];
            scatter[at].hypot(of_contact)
        })
    }

    /// Returns an instance's friction law: the dependence of φ and the lag on its parameters as slopes, and the remaining
    /// variance as scatter.
    pub(super) fn law(
        &self,
        friction: &TrialFriction,
        index: usize,
        covariance: &OfParameters,
    ) -> FrictionLaw<PARAMETERS> {
        let of = &friction.each[index];
        let with = self.with_parameters[index];
        let told = regression(covariance, &with);
        let rest = self.of_trial - with.tr_mul(&told);
        let mut law = friction.held(index);
        let by_trial = Matrix2::new(of.by_trial[FLOOR], of.by_trial[LAG_MS], 1.0, 0.0);
        law.slopes = (of.by_contact + told * of.by_trial).into();
        law.floor_slopes = told.column(FLOOR).into_owned().into();
        law.scatter += by_trial * rest * by_trial.transpose();
        law
    }
}

/// Variance below which a direction of parameters, scaled to unit variance, is rounding.
const ROUNDING: f64 = 1e-10;

/// Returns the regression slopes, on parameters with this covariance, of quantities with covariance `with` to them.
fn regression(
    covariance: &OfParameters,
    with: &SMatrix<f64, PARAMETERS, OF_TRIAL>,
) -> SMatrix<f64, PARAMETERS, OF_TRIAL> {
    let scale: SVector<f64, PARAMETERS> = covariance
        .diagonal()
        .map(|of| if of > 0.0 { of.sqrt().recip() } else { 0.0 });
    let scale = SMatrix::from_diagonal(&scale);
    let directions = (scale * covariance * scale).symmetric_eigen();
    let inverse = directions
        .eigenvalues
        .map(|of| if of > ROUNDING { of.recip() } else { 0.0 });
    let (vectors, inverse) = (directions.eigenvectors, SMatrix::from_diagonal(&inverse));
    scale * vectors * inverse * vectors.transpose() * scale * with
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With some exact parameters and one that is the sum of two others, the slopes still reproduce the covariance.
    #[test]
    fn slopes_give_the_covariance_of_what_they_were_made_of() {
        let follows = OfParameters::from_fn(|row, column| match (row, column) {
            (0..6, 0..6) => ((row * 5 + column * 3) % 7) as f64 * 0.1_f64.powi(row as i32),
            _ => 0.0,
        });
        let mut covariance = follows * follows.transpose();
        let sum = covariance.row(1) + covariance.row(2);
        covariance.set_row(6, &sum);
        let sum = covariance.column(1) + covariance.column(2);
        covariance.set_column(6, &sum);
        let slopes = SMatrix::<f64, PARAMETERS, OF_TRIAL>::from_fn(|row, column| {
            0.3 * row as f64 - column as f64
        });
        let with = covariance * slopes;
        let found = covariance * regression(&covariance, &with);
        let scale = covariance.diagonal().map(f64::sqrt);
        for (row, scale) in scale.iter().enumerate() {
            for column in 0..OF_TRIAL {
                let apart = (found[(row, column)] - with[(row, column)]).abs();
                assert!(apart <= 1e-6 * scale, "{row}: {apart} of {scale}");
            }
        }
    }
}
