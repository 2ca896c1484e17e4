//! Second fit of a trial, with the laws in doubt.
//!
//! The first fit takes the laws as published for true. From its minimum θ₁ the cost is minimised again with the parameters of the
//! laws in doubt free, to θ₂, with the same trends and the same course of the plate. With C the covariance at θ₂, which includes the
//! priors, the reported values are θ₁, with the mean square error about them that the second fit leaves:
//!
//! ```text
//! E (θ − θ₁)(θ − θ₁)ᵀ = C + (θ₂ − θ₁)(θ₂ − θ₁)ᵀ
//! ```
//!
//! θ₂ itself would scatter by a tenth in σ_t and a quarter in S where the published laws hold. A test of ℓ = 0 does not tell when it
//! is the better value: on the simulated bench `population-unkind`, of the published laws, errors that no parameter describes
//! (sensors, tremor, warmth) make ℓᵀ C_ℓℓ⁻¹ ℓ up to 275, as large as in most worlds of other laws.

use std::ops::RangeInclusive;

use arrowhead::minimise;

use super::layout::{
    FreeLaws, InstanceParameter, LAWS, Law, OWN, Own, PUBLISHED, Shared, SharedParameter,
};
use super::members::{Covariance, Step, TrialMinimum};
use super::search::{FINAL_TERMINATION, Search};
use crate::conditions::ModeAcross;
use contact::calibration_errors;

/// Number of times that the skin's transients and the weights of the samples are computed anew at the second minimum.
const REFINEMENTS: usize = 1;

/// Further start of a search that may have ended in a false valley.
struct Restart {
    law: Law,
    /// Values of a minimum that give reason to start again.
    suspect: RangeInclusive<f64>,
    start: f64,
}

/// Trapped air and width have no negative values: the starts are trapped air with as much stiffness as the rest of the film, and a
/// contact of 0.4 wavelengths. A contact of more than that is also searched from 0.6 wavelengths, where the mode changes its sign
/// under the edges. Each is tried with the tissues of the published laws and with those that fit it best.
const RESTARTS: [Restart; 3] = [
    Restart {
        law: Law::TrappedAir,
        suspect: f64::NEG_INFINITY..=-0.01,
        start: 0.03,
    },
    Restart {
        law: Law::Width,
        suspect: f64::NEG_INFINITY..=-0.05,
        start: 0.16,
    },
    Restart {
        law: Law::Width,
        suspect: 0.16..=f64::INFINITY,
        start: 0.35,
    },
];

/// Result of the second fit.
pub(super) struct Doubt {
    /// Minimum with the laws in doubt.
    pub(super) minimum: TrialMinimum,
    /// Covariance about the minimum with the laws as published.
    pub(super) covariance: Covariance,
}

impl Search<'_> {
    /// Returns the plate's mode across its width, if the wavelength is known.
    pub(super) fn mode_across(&self) -> Option<ModeAcross> {
        let mut members = self.members.iter();
        members.find_map(|member| member.model.mode_across)
    }

    /// Changes the laws in doubt that are fitted.
    pub(super) fn set_free_laws(&mut self, free_laws: FreeLaws) {
        self.free_laws = free_laws;
        for member in &mut self.members {
            member.set_free_laws(free_laws);
        }
    }

    /// Returns the number of fitted parameters.
    pub(super) fn parameter_count(&self) -> usize {
        let laws = self.free_laws.iter().filter(|is_free| **is_free).count();
        PUBLISHED + laws + OWN * self.members.len()
    }

    /// Fits the laws in doubt, from the minimum with the laws as published; `None` if the data and the priors do not determine them.
    /// The laws stay free, and the weights of the samples are restored.
    pub(super) fn doubt(&mut self, published: &TrialMinimum) -> Option<Doubt> {
        self.follow_fingers(published)?;
        let refinement = self.refinement();
        let by_error = self.unfitted_errors();
        let mut start = published.clone();
        for law in Law::ALL {
            if !self.free_laws[law as usize] {
                start.shared[SharedParameter::Law(law)] = 0.0;
            }
        }
        self.set_free_laws([true; LAWS]);
        let doubt = self.minimum_in_doubt(start).and_then(|minimum| {
            let covariance = self.covariance(&minimum, &by_error)?;
            let instances = minimum.own.iter().zip(&published.own);
            let difference = Step {
                shared: minimum.shared - published.shared,
                own: instances
                    .map(|(doubtful, published)| doubtful - published)
                    .collect(),
            };
            Some(Doubt {
                covariance: covariance.with_error(calibration_errors::LAWS, &difference),
                minimum,
            })
        });
        self.restore(refinement);
        doubt
    }

    /// Returns the parameters of the instances with the best Z_t and reactance of each; `None` where the model allows none.
    fn with_best_tissues(&mut self, shared: &Shared, own: &[Own]) -> Option<Vec<Own>> {
        let instances = own.iter().enumerate().map(|(index, own)| {
            let fits = self.fit_candidates(&[index], shared, own)?;
            let fit = fits.first()?;
            let mut start = *own;
            start[InstanceParameter::ReZT] = fit.z_t.re;
            start[InstanceParameter::ImZT] = fit.z_t.im;
            start[InstanceParameter::Reactance] += fit.reactance;
            Some(start)
        });
        instances.collect()
    }

    fn minimum_in_doubt(&mut self, start: TrialMinimum) -> Option<TrialMinimum> {
        let (shared, own) = (start.shared, start.own);
        let mut minimum = minimise(self, shared, own.clone(), FINAL_TERMINATION)?;
        for restart in RESTARTS {
            let parameter = SharedParameter::Law(restart.law);
            if restart.suspect.contains(&minimum.shared[parameter]) {
                let mut shared = shared;
                shared[parameter] = restart.start;
                let tissues = self.with_best_tissues(&shared, &own);
                for own in [Some(own.clone()), tissues].into_iter().flatten() {
                    let candidate = minimise(self, shared, own, FINAL_TERMINATION)
                        .filter(|candidate| candidate.squares < minimum.squares);
                    minimum = candidate.unwrap_or(minimum);
                }
            }
        }
        for _ in 0..REFINEMENTS {
            self.follow_fingers(&minimum)?;
            self.follow_transients(&minimum)?;
            self.weigh(&minimum, true);
            minimum = minimise(self, minimum.shared, minimum.own, FINAL_TERMINATION)?;
        }
        Some(minimum)
    }
}
