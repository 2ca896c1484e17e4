//! The model with the average σ_t of a participant, at each instance of theirs.
//!
//! A participant's σ_t is the mean over all their instances; of a recording whose participant is not known, over its own.

use std::collections::BTreeMap;

use contact::fit::{FitError, ModelledSeries, dynamic, paper};

use crate::analysed::{Analysed, RecordingFindings};
use crate::analysis_settings::Settings;
use crate::estimate::{Averaged, InstanceAnalysis};
use crate::method::Method;
use crate::statistics::r_squared_complex;

/// Whose average: a participant's, or that of the recording with this number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Whose {
    Participant(String),
    Recording(usize),
}

/// Gives each instance of an analysis the model with the average σ_t of its participant.
pub fn fill(analysed: &mut Analysed) {
    let settings = analysed.settings;
    let mut sigmas_m = BTreeMap::<Whose, Vec<[f64; 2]>>::new();
    for (number, found) in analysed.findings().enumerate() {
        let each = found
            .instances
            .iter()
            .map(|instance| Method::BOTH.map(|method| instance.estimated(method).sigma_t_m));
        sigmas_m
            .entry(whose(number, found))
            .or_default()
            .extend(each);
    }
    let mean_m = |of: &[[f64; 2]]| {
        let n = of.len() as f64;
        [0, 1].map(|method| of.iter().map(|sigma_m| sigma_m[method]).sum::<f64>() / n)
    };
    for (number, found) in analysed.findings_mut().enumerate() {
        let averages_m = mean_m(&sigmas_m[&whose(number, found)]);
        let carrier_hz = found.manifest.carrier_hz;
        let Some(z_p) = found.z_p else { continue };
        let conditions = z_p.conditions(settings.assumed(), carrier_hz);
        for instance in &mut found.instances {
            for (method, sigma_t_m) in Method::BOTH.into_iter().zip(averages_m) {
                let series = modelled(instance, method, &conditions, &settings, sigma_t_m).ok();
                let r2_impedance = series.as_ref().map_or(f64::NAN, |model| {
                    r_squared_complex(instance.z_m(method), &model.z_m_n_s_per_m)
                });
                instance.estimated_mut(method).averaged = Averaged {
                    sigma_t_m,
                    series,
                    r2_impedance,
                };
            }
        }
    }
    fill_trials(analysed);
}

/// The same by `trial`, whose skin is the recording's own.
fn fill_trials(analysed: &mut Analysed) {
    let settings = analysed.settings;
    let mut sigmas_m = BTreeMap::<Whose, Vec<f64>>::new();
    for (number, found) in analysed.findings().enumerate() {
        let fitted = found.instances.iter().filter_map(|i| i.trial.as_ref());
        let each = fitted.map(|trial| trial.sigma_t_m);
        sigmas_m
            .entry(whose(number, found))
            .or_default()
            .extend(each);
    }
    for (number, found) in analysed.findings_mut().enumerate() {
        let of_whose = &sigmas_m[&whose(number, found)];
        let sigma_t_m = of_whose.iter().sum::<f64>() / of_whose.len() as f64;
        let carrier_hz = found.manifest.carrier_hz;
        let Some(z_p) = found.z_p else { continue };
        for instance in &mut found.instances {
            let Some(trial) = &mut instance.trial else {
                continue;
            };
            let conditions = z_p.conditions(trial.skin, carrier_hz);
            let fitted = dynamic::AlongWith {
                tau_s: trial.tau_s.map_or(0.0, |(tau_s, _)| tau_s),
                z_p_n_s_per_m: trial.z_p_n_s_per_m,
            };
            let samples = instance.samples.series(Method::Dynamic);
            let series = samples
                .and_then(|samples| {
                    let options = settings.dynamic();
                    dynamic::modelled(&samples, &conditions, &options, sigma_t_m, &fitted)
                })
                .ok();
            let r2_impedance = series.as_ref().map_or(f64::NAN, |model| {
                r_squared_complex(instance.samples.z_m(Method::Dynamic), &model.z_m_n_s_per_m)
            });
            trial.averaged = Averaged {
                sigma_t_m,
                series,
                r2_impedance,
            };
        }
    }
}

fn whose(number: usize, found: &RecordingFindings) -> Whose {
    match found.participant() {
        Some(id) => Whose::Participant(id.to_owned()),
        None => Whose::Recording(number),
    }
}

fn modelled(
    instance: &InstanceAnalysis,
    method: Method,
    conditions: &contact::fit::FitConditions,
    settings: &Settings,
    sigma_t_m: f64,
) -> Result<ModelledSeries, FitError> {
    let series = instance.samples.series(method)?;
    match method {
        Method::Paper => paper::modelled(&series, conditions, &settings.paper(), sigma_t_m),
        Method::Dynamic => {
            let fitted = dynamic::AlongWith {
                tau_s: instance.finger.tau_s(),
                z_p_n_s_per_m: instance.finger.z_p_n_s_per_m(),
            };
            dynamic::modelled(&series, conditions, &settings.dynamic(), sigma_t_m, &fitted)
        }
    }
}
