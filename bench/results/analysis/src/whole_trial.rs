//! Fit of all instances of a recording together.

use estimation::trial::{self, PlacedInstance, PlateReadings, SharedFit, TrialOptions};
use estimation::{FitConditions, FitError};
use recording::manifest::RecordedPlate;

use crate::amplitude_profile::AmplitudeProfile;
use crate::analysis_settings::Settings;
use crate::estimate::{InstanceAnalysis, MeasuredValues};
use crate::findings::RecordingFindings;
use crate::recording_series::SampledInstance;
use crate::within_laws;

/// Parameters shared by the instances of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedFits {
    /// Parameters whose errors include the laws in doubt.
    pub total: SharedFit,
    /// Parameters with the laws as published taken as true.
    pub within_laws: Option<SharedFit>,
}

/// Fits the instances together, and adds the estimates to each, and to its samples, if the fit can be used.
///
/// # Errors
/// The instances cannot be fitted together.
pub fn fit(
    (instances, samples): (&mut [InstanceAnalysis], &mut [SampledInstance]),
    (conditions, plate): (&FitConditions, &RecordedPlate),
    readings: &PlateReadings,
    settings: &Settings,
) -> Result<SharedFits, FitError> {
    let placements: Vec<PlacedInstance<'_>> = samples
        .iter()
        .map(|sampled| sampled.samples.placement(plate.centre_m))
        .collect::<Result<_, _>>()?;
    let options = options(settings.trial(), &AmplitudeProfile::from(plate));
    let trial_fit = trial::fit(&placements, conditions, readings, &options)?;
    let within_laws = trial_fit.within_laws.as_ref();
    if trial_fit.shared.verdict.is_usable() {
        let shared_within_laws = within_laws.map(|fit| &fit.shared);
        let holds = within_laws::holding(&trial_fit.shared, shared_within_laws).is_some();
        let fits_within_laws = within_laws.filter(|_| holds);
        let fits_within_laws = fits_within_laws.map_or(&[][..], |fit| &fit.instances);
        let instances = instances.iter_mut().zip(samples);
        for (index, ((instance, sampled), fit)) in instances.zip(trial_fit.instances).enumerate() {
            let measurement =
                MeasuredValues::new(&sampled.samples, conditions, plate.modal_mass_kg);
            let rest_z_m = instance.paper.rest.map(|rest| rest.z_m_corrected_n_s_per_m);
            let (estimated, series) =
                measurement.lagged_estimate(fit, rest_z_m.unwrap_or(f64::NAN.into()));
            let fit_within_laws = fits_within_laws.get(index);
            instance.within_laws = fit_within_laws.map(|fit| measurement.within_laws(fit));
            instance.trial = Some(estimated);
            sampled.trial = Some(series);
        }
    }
    Ok(SharedFits {
        total: trial_fit.shared,
        within_laws: trial_fit.within_laws.map(|fit| fit.shared),
    })
}

/// Returns the options for a plate with this profile along its length.
pub fn options(mut options: TrialOptions, profile: &AmplitudeProfile) -> TrialOptions {
    if profile.is_measured() {
        options.priors = options.priors.with_mode_shape();
    }
    options
}

/// Returns the shared parameters' 95 % intervals, in a line with the laws in doubt included and a line with the published ones
/// taken as true, or the reason why there are none.
pub fn lines(findings: &RecordingFindings) -> Vec<String> {
    let Some(total) = &findings.trial else {
        return Vec::new();
    };
    if !total.verdict.is_usable() {
        return vec![format!("trial: {}", total.verdict)];
    }
    if let Some(sign) = total.misfit.first() {
        return vec![format!("trial: the model does not hold: {sign}")];
    }
    let mut lines = vec![format!("trial: {}", intervals(total))];
    let within_laws = match (findings.fit_within_laws(), &findings.within_laws) {
        (Some(fit), _) => Some(intervals(fit)),
        (None, Some(fit)) => fit
            .misfit
            .first()
            .map(|sign| format!("they do not hold: {sign}")),
        (None, None) => None,
    };
    lines.extend(within_laws.map(|text| format!("within the published laws: {text}")));
    lines
}

fn intervals(shared: &SharedFit) -> String {
    let [area_low, area_high] = shared.contact_area_m2.interval95().map(|end| end * 1e6);
    let [q0_low, q0_high] = shared.q0_rad_per_m.interval95().map(|end| end * 1e-4);
    let [loss_low, loss_high] = shared.loss_factor.interval95();
    let [tau_low, tau_high] = shared.tau_s.interval95().map(|end| end * 1e3);
    format!(
        "S {area_low:.0} to {area_high:.0} mm², q0 {q0_low:.2} to {q0_high:.2} × 10⁴ rad/m, \
         η {loss_low:.3} to {loss_high:.3}, τ {tau_low:.2} to {tau_high:.2} ms"
    )
}
