//! Fit of all instances of a recording together.

use estimation::trial::{self, PlacedInstance, PlateReadings, SharedFit, TrialOptions};
use estimation::{FitConditions, FitError};
use recording::manifest::RecordedPlate;

use crate::amplitude_profile::AmplitudeProfile;
use crate::analysis_settings::Settings;
use crate::estimate::{InstanceAnalysis, MeasuredValues};

/// Fits the instances together, and adds an estimate to each if the fit can be used.
///
/// # Errors
/// The instances cannot be fitted together.
pub fn fit(
    instances: &mut [InstanceAnalysis],
    (conditions, plate): (&FitConditions, &RecordedPlate),
    readings: &PlateReadings,
    settings: &Settings,
) -> Result<SharedFit, FitError> {
    let placements: Vec<PlacedInstance<'_>> = instances
        .iter()
        .map(|instance| instance.samples.placement(plate.centre_m))
        .collect::<Result<_, _>>()?;
    let options = options(settings.trial(), &AmplitudeProfile::from(plate));
    let trial_fit = trial::fit(&placements, conditions, readings, &options)?;
    if trial_fit.shared.verdict.is_usable() {
        for (instance, fit) in instances.iter_mut().zip(trial_fit.instances) {
            let measurement =
                MeasuredValues::new(&instance.samples, conditions, plate.modal_mass_kg);
            let rest_z_m = instance.paper.rest.map(|rest| rest.z_m_corrected_n_s_per_m);
            let estimated = measurement.lagged_estimate(fit, rest_z_m.unwrap_or(f64::NAN.into()));
            instance.trial = Some(estimated);
        }
    }
    Ok(trial_fit.shared)
}

/// Returns the options for a plate with this profile along its length.
pub(crate) fn options(mut options: TrialOptions, profile: &AmplitudeProfile) -> TrialOptions {
    if profile.is_measured() {
        options.priors = options.priors.with_mode_shape();
    }
    options
}

/// Returns the shared parameters' 95 % intervals, or the reason why there are none, in one line.
pub fn line(shared: &SharedFit) -> String {
    if !shared.verdict.is_usable() {
        return format!("trial: {}", shared.verdict);
    }
    if let Some(sign) = shared.misfit.first() {
        return format!("trial: the model does not hold: {sign}");
    }
    let [area_low, area_high] = shared.contact_area_m2.interval95().map(|end| end * 1e6);
    let [q0_low, q0_high] = shared.q0_rad_per_m.interval95().map(|end| end * 1e-4);
    let [loss_low, loss_high] = shared.loss_factor.interval95();
    let [tau_low, tau_high] = shared.tau_s.interval95().map(|end| end * 1e3);
    format!(
        "trial: S {area_low:.0} to {area_high:.0} mm², q0 {q0_low:.2} to {q0_high:.2} × 10⁴ rad/m, \
         η {loss_low:.3} to {loss_high:.3}, τ {tau_low:.2} to {tau_high:.2} ms"
    )
}
