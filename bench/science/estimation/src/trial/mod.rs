//! One fit of all instances of a trial, without assumed constants of the skin.
//!
//! σ_t, Z_t and the plate's offset belong to an instance; S, q0, η and τ are shared by all instances of a trial and fitted. A
//! single instance hardly separates S from τ, but a trial does: S follows from the film's force (Huloux 2021, Eq. 14) and the
//! measured normal force, q0 from the gap at rest (Eq. 16), η from the phase of the contact (Eq. 7). Only q0 E/(1 − ν²) and p0
//! S enter, so q0 is the value for the assumed E and ν.
//!
//! The impedance, the gap's lag and the normal force are those of [`dynamic`](super::dynamic); in addition the skin has inertia
//! while the amplitude changes (`transient.rs`). With r_i the 2n real and imaginary parts of Z_m,model − Z_m of instance i and
//! V_i their covariance (`scatter.rs`), the sum
//!
//! ```text
//! C = Σ_i r_iᵀV_i⁻¹ r_i + Σ_j ((θ_j − m_j)/s_j)²
//! ```
//!
//! is minimised: −2 ln of the posterior for normal residuals and normal [priors](TrialPriors) m_j ± s_j, up to a constant while
//! the V_i are fixed. Unknowns of an instance are ln σ_t, Re Z_t, Im Z_t, the plate's offset Δ (two parts), and the angle φ and
//! residual mobility y_r of other modes; σ_t and Z_t have no prior. Shared are ln S, ln q0, ln η, ln τ, ν, ln T, p
//! (`lagged_model`), five deviations of the plate from its predicted course (`plate.rs`), tilt and bow of the amplitude
//! along the plate, and common parts of φ and y_r.
//!
//! 1. Each of up to four pairs of S and τ starts from the best q0 and σ_t of a grid and descends with V = (0.01 N·s/m)² and
//!    narrowed priors of the extensions (`search.rs`).
//! 2. The best minimum is refined three times: trends within instances, the plate's course, the skin's transients and V are
//!    computed at it and held fixed, and C is minimised again (`arrowhead`).
//! 3. Without later readings of the plate, its damping is freed where the Bayesian information criterion favours that.
//! 4. The laws in doubt are freed (`doubt.rs`), which widens the errors and leaves the values.
//! 5. The covariance follows from residuals, priors and the errors of the calibration; the friction is fitted to the contact
//!    found (`solution.rs`, `friction`).

mod doubt;
mod friction;
mod friction_spread;
mod identifiability;
mod layout;
mod members;
mod misfit;
mod plate;
mod prior;
mod request;
mod scatter;
mod search;
mod shared_fit;
mod solution;
mod trial_fit;

pub use misfit::Misfit;
pub use plate::{PlateReadings, PlateReference};
pub use prior::{LawPriors, LogNormal, Normal, TrialPriors};
pub use request::{PlacedInstance, TrialOptions};
pub use shared_fit::SharedFit;
pub use trial_fit::TrialFit;

use search::Search;
use solution::Solution;

use super::conditions::FitConditions;
use super::fit_error::FitError;

/// Fits all instances of a trial, using the plate's `readings`.
///
/// # Errors
/// If there is no instance, a lead-in is too short, or the model allows no such contacts.
pub fn fit(
    places: &[PlacedInstance<'_>],
    conditions: &FitConditions,
    readings: &PlateReadings,
    options: &TrialOptions,
) -> Result<TrialFit, FitError> {
    let members = members::members(places, conditions, readings, options)?;
    if members.is_empty() {
        return Err(FitError::NoStart);
    }
    let mut search = Search::new(members, readings, options.priors);
    search.set_calibration(conditions.calibration);
    let published = search.solve()?;
    let within_laws = Solution::new(&mut search, published.clone())?.trial_fit()?;
    search.set_calibration(conditions.total_errors());
    let Some(doubt) = search.doubt(&published) else {
        // Without the second fit the errors lack the doubt about the laws, so that they must not be taken for the whole.
        return Ok(within_laws.without_doubt());
    };
    let verdict = within_laws.shared.verdict.clone();
    let solution = Solution::in_doubt(&mut search, published, doubt, verdict)?;
    Ok(TrialFit {
        within_laws: Some(Box::new(within_laws)),
        ..solution.trial_fit()?
    })
}
