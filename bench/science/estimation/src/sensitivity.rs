//! Dependence of the fitted values on the assumed constants.

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use contact::AssumedConstants;
use serde::{Deserialize, Serialize};

/// Derivatives of the fitted values by the logarithm of one assumed constant θ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// ∂ln σ_t/∂ln θ.
    pub ln_sigma_t: f64,
    /// ∂ln |Z_t|/∂ln θ.
    pub ln_abs_z_t: f64,
    /// ∂τ/∂ln θ, s; 0 for `paper`, which has no τ.
    pub tau_s: f64,
}

/// Dependence of the fitted values on the assumed constants, from central differences of refits at ±1 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sensitivities {
    /// Sensitivity to q0.
    pub q0: Sensitivity,
    /// Sensitivity to E.
    pub young_modulus: Sensitivity,
    /// Sensitivity to ν.
    pub poisson_ratio: Sensitivity,
    /// Sensitivity to S.
    pub contact_area: Sensitivity,
}

/// Values of a refit.
pub(super) struct Refit {
    pub(super) ln_sigma_t: f64,
    /// Z_t, N·s/m.
    pub(super) z_t: Complex64,
    /// τ, s; 0 for `paper`.
    pub(super) tau_s: f64,
}

/// Returns central differences of refits. The asperity law depends on q0, E and ν only through
/// q0 E/(1 − ν²).
pub(super) fn sensitivities(
    conditions: &FitConditions,
    refit: impl Fn(&FitConditions) -> Result<Refit, FitError>,
) -> Result<Sensitivities, FitError> {
    const STEP: f64 = 0.01;
    let central_difference = |vary: fn(&mut AssumedConstants, f64)| {
        let fit_at = |factor: f64| {
            let mut variant = *conditions;
            vary(&mut variant.assumed, factor);
            refit(&variant)
        };
        let (above, below) = (fit_at(STEP.exp())?, fit_at((-STEP).exp())?);
        let slope = |a: f64, b: f64| (a - b) / (2.0 * STEP);
        Ok::<_, FitError>(Sensitivity {
            ln_sigma_t: slope(above.ln_sigma_t, below.ln_sigma_t),
            ln_abs_z_t: slope(above.z_t.norm().ln(), below.z_t.norm().ln()),
            tau_s: slope(above.tau_s, below.tau_s),
        })
    };
    let q0 = central_difference(|assumed, factor| assumed.q0_rad_per_m *= factor)?;
    let contact_area = central_difference(|assumed, factor| assumed.contact_area_m2 *= factor)?;
    // −d ln(1 − ν²)/d ln ν = 2ν²/(1 − ν²).
    let nu_squared = conditions.assumed.poisson_ratio.powi(2);
    let per_nu = 2.0 * nu_squared / (1.0 - nu_squared);
    let poisson_ratio = Sensitivity {
        ln_sigma_t: q0.ln_sigma_t * per_nu,
        ln_abs_z_t: q0.ln_abs_z_t * per_nu,
        tau_s: q0.tau_s * per_nu,
    };
    Ok(Sensitivities {
        q0,
        young_modulus: q0,
        poisson_ratio,
        contact_area,
    })
}
