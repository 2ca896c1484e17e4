//! Result of a fit for the parameters that the instances of a trial share.

use super::misfit::Misfit;
use crate::fit_verdict::FitVerdict;
use contact::uncertain::{LogUncertain, Uncertain};
use serde::{Deserialize, Serialize};

/// Parameters that the instances of a trial share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedFit {
    /// Whether the parameters, including those of the instances, may be used.
    pub verdict: FitVerdict,
    /// Apparent contact area S under the mean normal force of all instances, m².
    pub contact_area_m2: LogUncertain,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: LogUncertain,
    /// Loss factor η.
    pub loss_factor: LogUncertain,
    /// Levitation lag τ at the mean gap of all instances, s.
    pub tau_s: LogUncertain,
    /// Exponent ν of the area's growth with the normal force.
    pub area_exponent: Uncertain,
    /// Time over which the film averages the squared amplitude, s: marginalised rather than measured. A recording shows mostly its
    /// sum with τ, so that the value depends more on the prior than on the finger, and has no standard error.
    pub film_mean_s: f64,
    /// Exponent of the lag's growth with the gap.
    pub lag_exponent: Uncertain,
    /// Signs that the model does not hold; if there are any, the standard errors cannot be trusted.
    pub misfit: Vec<Misfit>,
    /// Floor φ of friction as a fraction of μ0; `None` if the measured friction could not be fitted.
    pub friction_floor: Option<Uncertain>,
    /// Lag of the lateral force, s; `None` if the measured friction could not be fitted.
    pub lateral_lag_s: Option<Uncertain>,
}

impl SharedFit {
    /// Whether the fit can be used and shows no sign that the model does not hold.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.verdict.is_usable() && self.misfit.is_empty()
    }
}
