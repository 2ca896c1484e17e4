//! Quantities of `trial`, and those of them that hold under every law tried.

use maud::{Markup, html};
use serde::Serialize;

/// Quantity that `trial` estimates, serialised as its key in the results file or as its column of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum TrialQuantity {
    /// σ_t.
    #[serde(rename = "sigma_t_m")]
    SigmaT,
    /// Z_t.
    #[serde(rename = "z_t_n_s_per_m")]
    ZT,
    /// μ0.
    #[serde(rename = "mu0")]
    Mu0,
    /// Friction over time.
    #[serde(rename = "mu")]
    Mu,
    /// Gap over time, in units of σ_t.
    #[serde(rename = "gap_per_sigma_t")]
    GapPerSigmaT,
    /// Shift of the plate's resonance.
    #[serde(rename = "resonance_shift_hz")]
    ResonanceShift,
    /// S.
    #[serde(rename = "contact_area_m2")]
    ContactArea,
    /// q0.
    #[serde(rename = "q0_rad_per_m")]
    Q0,
    /// η.
    #[serde(rename = "loss_factor")]
    LossFactor,
    /// τ.
    #[serde(rename = "tau_s")]
    Tau,
    /// Exponent of S with the normal force.
    #[serde(rename = "area_force_exponent")]
    AreaForceExponent,
    /// Exponent of τ with the gap.
    #[serde(rename = "lag_gap_exponent")]
    LagGapExponent,
    /// Floor of friction.
    #[serde(rename = "friction_floor")]
    FrictionFloor,
    /// Lag of the lateral force.
    #[serde(rename = "lateral_lag_s")]
    LateralLag,
}

/// Quantities whose estimate by the published laws stays within the accuracy of docs/accuracy.md in every simulated world with other
/// laws and sound sensors (the test `a_world_of_other_laws_is_right_covered_or_flagged`).
pub const HOLDS_UNDER_EVERY_LAW_TRIED: &[TrialQuantity] = &[TrialQuantity::Mu0];

impl TrialQuantity {
    /// Returns the mark of a quantity that is among those that hold.
    pub(crate) fn mark(self, holds: &[Self]) -> Markup {
        html! { @if holds.contains(&self) { sup title="holds under every law tried" { "†" } } }
    }
}

/// Returns the explanation of the marks; empty without any.
pub(crate) fn marks_note(holds: &[TrialQuantity]) -> Markup {
    html! { @if !holds.is_empty() { p.note { "† Holds under every law tried." } } }
}
