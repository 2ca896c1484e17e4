//! Second fit of a trial, with the laws in doubt.
//!
//! The first fit takes the laws as published for true. From its minimum θ₁ the cost is minimised again with the parameters ℓ of the
//! laws in doubt free, to θ₂. Both are held to the same trends, transients and course of the plate. With C the covariance at θ₂,
//! which includes the priors, the laws as published are rejected if
//!
//! ```text
//! Q = ℓ₂ᵀ C_ℓℓ⁻¹ ℓ₂ > 16.8
//! ```
//!
//! which χ² of six degrees of freedom exceeds in 1 %. While they are not, the values of the first fit are the better ones wherever
//! the published laws hold, and θ₂ scatters about them by errors that the data do not resolve. Then θ₁ is reported, with the mean
//! square error about it that the second fit leaves,
//!
//! ```text
//! E (θ − θ₁)(θ − θ₁)ᵀ = C + (θ₂ − θ₁)(θ₂ − θ₁)ᵀ
//! ```
//!
//! Where they are rejected, θ₂ is refined and reported with its own covariance.

use crate::arrowhead::minimise;
use nalgebra::{DMatrix, DVector};

use super::layout::{LAWS, Law, SharedParameter};
use super::members::{Covariance, Step, TrialMinimum};
use super::search::{FINAL_TERMINATION, Search};
use crate::fit_error::FitError;
use contact::calibration_errors::ByError;
use contact::parameters::PARAMETERS;

/// Largest Q of laws in doubt about the published ones: 99 % of χ² of six degrees of freedom.
const MAX_SQUARES: f64 = 16.8;

/// Further starts: a tenth of the film's stiffness from trapped air, and a contact of 0.4 wavelengths.
const POSITIVE_STARTS: [(Law, f64); 2] = [(Law::TrappedAir, 0.03), (Law::Width, 0.16)];

/// Result of the second fit.
pub(super) enum Doubt {
    /// The data do not reject the laws as published.
    Agreement {
        /// Minimum with the laws in doubt.
        minimum: TrialMinimum,
        /// θ₂ − θ₁.
        difference: Step,
    },
    /// They do; minimum with the laws in doubt.
    Rejection(TrialMinimum),
}

impl Search<'_> {
    /// Fits the laws in doubt, from the minimum with the laws as published.
    pub(super) fn doubt(
        &mut self,
        published: &TrialMinimum,
        by_error: &ByError<PARAMETERS>,
    ) -> Result<Doubt, FitError> {
        let was_free = self.free_laws;
        self.follow_fingers(published).ok_or(FitError::NoStart)?;
        self.set_free_laws([true; LAWS]);
        let mut start = published.clone();
        for law in Law::ALL {
            if !was_free[law as usize] {
                start.shared[SharedParameter::Law(law)] = 0.0;
            }
        }
        let minimum =
            minimise(self, start.shared, start.own, FINAL_TERMINATION).ok_or(FitError::NoStart)?;
        let laws: Vec<Law> = Law::ALL
            .into_iter()
            .filter(|law| !was_free[*law as usize])
            .collect();
        let covariance = self.covariance(&minimum, by_error);
        let squares = covariance
            .as_ref()
            .and_then(|covariance| squares(&minimum, covariance, &laws));
        if true {
            //DEBUG
            let stds: Vec<f64> = covariance
                .as_ref()
                .map(|c| {
                    Law::ALL
                        .iter()
                        .map(|l| {
                            c.shared[(
                                SharedParameter::Law(*l).position(),
                                SharedParameter::Law(*l).position(),
                            )]
                                .sqrt()
                        })
                        .collect()
                })
                .unwrap_or_default();
            let laws: Vec<String> = Law::ALL
                .iter()
                .zip(stds)
                .map(|(l, s)| format!("{:.4}±{:.4}", minimum.shared[SharedParameter::Law(*l)], s))
                .collect();
            let m = minimum.own.len() / 2;
            let sd = covariance
                .as_ref()
                .map_or(f64::NAN, |c| c.blocks[m].own[(0, 0)].sqrt());
            let ssd = covariance
                .as_ref()
                .map_or(f64::NAN, |c| c.shared[(0, 0)].sqrt());
            eprintln!(
                "DOUBT Q {:.1} C {:.1} -> {:.1} conv {} {} | sigma {:.4} -> {:.4} ± {:.3} S {:.1} -> {:.1} ± {:.3} zt {:.2}{:+.2}i -> {:.2}{:+.2}i | {}",
                squares.unwrap_or(f64::NAN),
                published.squares,
                minimum.squares,
                published.converged,
                minimum.converged,
                published.own[m][0].exp() * 1e6,
                minimum.own[m][0].exp() * 1e6,
                sd,
                published.shared[0].exp() * 1e6,
                minimum.shared[0].exp() * 1e6,
                ssd,
                published.own[m][1],
                published.own[m][2],
                minimum.own[m][1],
                minimum.own[m][2],
                laws.join(" ")
            );
        }
        if squares.is_some_and(|squares| squares > MAX_SQUARES) {
            let physical = self.physical_minimum(published, minimum.clone())?;
            let before = self.refinement();
            if let Ok(refined) = self.refine(physical) {
                eprintln!(
                    "REFINED C {:.1} conv {} sigma {:.4} S {:.1} laws {:?}",
                    refined.squares,
                    refined.converged,
                    refined.own[refined.own.len() / 2][0].exp() * 1e6,
                    refined.shared[0].exp() * 1e6,
                    Law::ALL.map(|l| refined.shared[SharedParameter::Law(l)])
                );
                return Ok(Doubt::Rejection(refined));
            }
            self.restore(before);
        }
        let own = minimum.own.iter().zip(&published.own);
        let difference = Step {
            shared: minimum.shared - published.shared,
            own: own
                .map(|(doubtful, published)| doubtful - published)
                .collect(),
        };
        Ok(Doubt::Agreement {
            minimum,
            difference,
        })
    }
}

impl Search<'_> {
    /// Returns the lowest of a minimum and those from starts with more trapped air or a wider contact, where its own are negative:
    /// such a valley may be a false one.
    fn physical_minimum(
        &mut self,
        published: &TrialMinimum,
        mut minimum: TrialMinimum,
    ) -> Result<TrialMinimum, FitError> {
        for (law, value) in POSITIVE_STARTS {
            let parameter = SharedParameter::Law(law);
            if minimum.shared[parameter] >= 0.0 {
                continue;
            }
            let mut shared = published.shared;
            shared[parameter] = value;
            let other = minimise(self, shared, published.own.clone(), FINAL_TERMINATION);
            let other = other.filter(|other| other.squares < minimum.squares);
            minimum = other.unwrap_or(minimum);
        }
        Ok(minimum)
    }
}

/// Returns Q = ℓᵀ C_ℓℓ⁻¹ ℓ of some laws.
fn squares(minimum: &TrialMinimum, covariance: &Covariance, laws: &[Law]) -> Option<f64> {
    let place = |index: usize| SharedParameter::Law(laws[index]).position();
    let n = laws.len();
    let block = DMatrix::from_fn(n, n, |row, column| {
        covariance.shared[(place(row), place(column))]
    });
    let values = DVector::from_fn(n, |index, _| minimum.shared[place(index)]);
    Some(values.dot(&block.cholesky()?.solve(&values)))
}
