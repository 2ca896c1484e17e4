//! Whether the data determine the parameters of a trial.

use super::layout::{InstanceParameter, SharedParameter};
use super::members::{Covariance, TrialMinimum};
use crate::fit_verdict::{FitParameter, FitVerdict, StandardError, find_unidentified};

/// Returns whether the parameters may be used: the search converged and all relative errors are small.
pub(super) fn verdict(minimum: &TrialMinimum, covariance: Option<&Covariance>) -> FitVerdict {
    if !minimum.converged {
        return FitVerdict::NotConverged {
            reason: "the search for the least squares did not end".to_owned(),
        };
    }
    let Some(covariance) = covariance else {
        return FitVerdict::NotIdentifiable {
            parameter: FitParameter::SigmaT,
            std: f64::INFINITY,
        };
    };
    let instance_errors = minimum.own.iter().enumerate().flat_map(|(index, own)| {
        let variances = covariance.blocks[index].own.diagonal();
        // Relative error of |Z_t|: √(E|δZ_t|²)/|Z_t|.
        let tissue = [InstanceParameter::ReZT, InstanceParameter::ImZT];
        let tissue_variance: f64 = tissue.map(|part| variances[part]).iter().sum();
        let tissue_square: f64 = tissue.map(|part| own[part] * own[part]).iter().sum();
        let sigma_t_variance = variances[InstanceParameter::LnSigmaT];
        [
            StandardError::relative(FitParameter::SigmaT, sigma_t_variance.sqrt()),
            StandardError::relative(FitParameter::ZT, (tissue_variance / tissue_square).sqrt()),
        ]
    });
    let area_variance = covariance.shared.diagonal()[SharedParameter::LnArea];
    let area = StandardError::relative(FitParameter::ContactArea, area_variance.sqrt());
    find_unidentified(instance_errors.chain([area])).unwrap_or(FitVerdict::Converged)
}
