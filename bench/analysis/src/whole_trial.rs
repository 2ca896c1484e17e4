//! The fit of all instances of a recording together.

use std::fmt;

use contact::fit::trial::{self, TrialFit};
use contact::fit::{FitConditions, FitError, FitVerdict, InstanceSeries};
use contact::live_estimator::Uncertain;

use crate::analysis_settings::Settings;
use crate::estimate::{InstanceAnalysis, Measured, Method};

/// What the instances of a trial have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeTrial {
    /// Whether the fit may be used.
    pub verdict: FitVerdict,
    /// Apparent contact area S, m², with the standard error of its logarithm.
    pub contact_area_m2: Uncertain,
    /// q0 for the assumed E and ν, rad/m, with the standard error of its logarithm.
    pub q0_rad_per_m: Uncertain,
    /// Loss factor η, with the standard error of its logarithm.
    pub loss_factor: Uncertain,
    /// Levitation lag τ, s, with the standard error of its logarithm.
    pub tau_s: Uncertain,
    /// Floor of friction as a part of μ0, with its standard error; `None` if the measured friction could not be fitted.
    pub friction_floor: Option<Uncertain>,
    /// Lag of the lateral force, s, with its standard error.
    pub lateral_lag_s: Option<Uncertain>,
    /// Number of instances.
    pub instances: usize,
}

impl fmt::Display for WholeTrial {
    /// Writes the trial's findings with their 95 % intervals, in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.verdict.is_usable() {
            return write!(f, "trial: {}", self.verdict);
        }
        let span = |of: Uncertain, unit: f64| {
            let factor = (WITHIN * of.std).exp();
            [of.value / factor * unit, of.value * factor * unit]
        };
        let [area, most_area] = span(self.contact_area_m2, 1e6);
        let [q0, most_q0] = span(self.q0_rad_per_m, 1e-4);
        let [loss, most_loss] = span(self.loss_factor, 1.0);
        let [tau, most_tau] = span(self.tau_s, 1e3);
        write!(
            f,
            "trial: S {area:.0} to {most_area:.0} mm², q0 {q0:.2} to {most_q0:.2} × 10⁴ rad/m, η {loss:.3} to {most_loss:.3}, τ \
             {tau:.2} to {most_tau:.2} ms"
        )
    }
}

/// Standard errors on either side of a 95 % interval.
pub(crate) const WITHIN: f64 = 1.959_964;

/// Fits the instances together, and gives each its estimate if the fit can be used.
///
/// # Errors
/// The instances cannot be fitted together.
pub fn fit(
    instances: &mut [InstanceAnalysis],
    (conditions, modal_mass_kg): (&FitConditions, f64),
    settings: &Settings,
) -> Result<WholeTrial, FitError> {
    let samples: Vec<InstanceSeries<'_>> = instances
        .iter()
        .map(|instance| instance.samples.series(Method::Dynamic))
        .collect::<Result<_, _>>()?;
    let TrialFit {
        verdict,
        contact_area_m2,
        q0_rad_per_m,
        loss_factor,
        tau_s,
        friction_floor,
        lateral_lag_s,
        instances: fits,
    } = trial::fit(&samples, conditions, &settings.trial())?;
    let whole = WholeTrial {
        contact_area_m2,
        q0_rad_per_m,
        loss_factor,
        tau_s,
        friction_floor,
        lateral_lag_s,
        instances: fits.len(),
        verdict,
    };
    if whole.verdict.is_usable() {
        for (instance, fit) in instances.iter_mut().zip(fits) {
            let measured = Measured::of(&instance.samples, conditions, modal_mass_kg);
            let at_rest = instance.paper.rest.map(|rest| rest.z_m_corrected_n_s_per_m);
            let estimated = measured.lagged(fit, at_rest.unwrap_or(f64::NAN.into()), None);
            instance.trial = Some(estimated);
        }
    }
    Ok(whole)
}
