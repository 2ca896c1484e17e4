//! Fit of all instances of a recording together.

use estimation::trial::{self, Placed, PlateReadings, SharedFit, TrialOptions};
use estimation::{FitConditions, FitError};
use recording::manifest::RecordedPlate;

use crate::amplitude_profile::AmplitudeProfile;
use crate::analysis_settings::Settings;
use crate::estimate::{InstanceAnalysis, Measured};

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
    let placed: Vec<Placed<'_>> = instances
        .iter()
        .map(|instance| instance.samples.placed(plate.centre_m))
        .collect::<Result<_, _>>()?;
    let options = options(settings.trial(), &AmplitudeProfile::from(plate));
    let fitted = trial::fit(&placed, conditions, readings, &options)?;
    if fitted.shared.verdict.is_usable() {
        for (instance, fit) in instances.iter_mut().zip(fitted.instances) {
            let measured = Measured::of(&instance.samples, conditions, plate.modal_mass_kg);
            let at_rest = instance.paper.rest.map(|rest| rest.z_m_corrected_n_s_per_m);
            let estimated = measured.lagged(fit, at_rest.unwrap_or(f64::NAN.into()), None);
            instance.trial = Some(estimated);
        }
    }
    Ok(fitted.shared)
}

/// Returns the options for a plate with this profile along its length.
pub(crate) fn options(mut options: TrialOptions, profile: &AmplitudeProfile) -> TrialOptions {
    if profile.is_measured() {
        options.priors = options.priors.on_a_measured_plate();
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
    let [area, most_area] = shared.contact_area_m2.interval95().map(|of| of * 1e6);
    let [q0, most_q0] = shared.q0_rad_per_m.interval95().map(|of| of * 1e-4);
    let [loss, most_loss] = shared.loss_factor.interval95();
    let [tau, most_tau] = shared.tau_s.interval95().map(|of| of * 1e3);
    format!(
        "trial: S {area:.0} to {most_area:.0} mm², q0 {q0:.2} to {most_q0:.2} × 10⁴ rad/m, η {loss:.3} to {most_loss:.3}, τ \
         {tau:.2} to {most_tau:.2} ms"
    )
}
