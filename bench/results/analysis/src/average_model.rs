//! Model with the average σ_t of a participant, at each of their instances.
//!
//! A participant's σ_t is the mean over all their instances; if the participant is unknown, over those of the recording.

use std::collections::BTreeMap;

use contact::Contact;
use estimation::{FitConditions, FitError, ModelledSeries, dynamic, paper};

use crate::analysis_settings::Settings;
use crate::estimate::{Averaged, InstanceAnalysis, InstanceEstimate};
use crate::findings::{Analysis, RecordingFindings};
use crate::instance::PreparedInstance;
use crate::method::Method;
use crate::statistics::r_squared_complex;

/// Subject of the average: a participant, or the recording with this number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Subject {
    Participant(String),
    Recording(usize),
}

/// Adds to each estimate of an analysis the model with its participant's average σ_t by the same method.
pub fn fill(analysed: &mut Analysis) {
    let settings = analysed.settings;
    let mut sigmas_m = BTreeMap::<(Subject, &str), Vec<f64>>::new();
    for (number, findings) in analysed.findings().enumerate() {
        for estimate in findings
            .instances
            .iter()
            .flat_map(InstanceAnalysis::estimates)
        {
            sigmas_m
                .entry((subject(number, findings), estimate.method.name()))
                .or_default()
                .push(estimate.estimate.sigma_t_m);
        }
    }
    for (number, findings) in analysed.findings_mut().enumerate() {
        let subject = subject(number, findings);
        let average_m = |name| {
            let values_m = sigmas_m.get(&(subject.clone(), name));
            values_m.map_or(f64::NAN, |values_m| {
                values_m.iter().sum::<f64>() / values_m.len() as f64
            })
        };
        let Some(shared_conditions) = findings.conditions(&settings) else {
            continue;
        };
        let floor = findings
            .trial
            .as_ref()
            .and_then(|shared| shared.friction_floor);
        let floor = floor.map(|floor| floor.value);
        for instance in &mut findings.instances {
            let samples = &instance.samples;
            for (method, estimated) in [
                (Method::Paper, Some(&mut instance.paper)),
                (Method::Dynamic, Some(&mut instance.dynamic)),
                (Method::Trial, instance.trial.as_mut()),
            ] {
                let Some(estimated) = estimated else { continue };
                let sigma_t_m = average_m(method.name());
                let conditions = FitConditions {
                    assumed: estimated.skin,
                    ..shared_conditions
                };
                let series = model_series(
                    samples,
                    method,
                    estimated,
                    &conditions,
                    &settings,
                    sigma_t_m,
                );
                let mut series = series.ok();
                if let (Method::Trial, Some(model), Some(floor)) = (method, &mut series, floor) {
                    let normal_n = samples.finger_force_n();
                    model.mu = mu_with_floor(model, estimated, sigma_t_m, normal_n, floor);
                }
                let r2_impedance = series.as_ref().map_or(f64::NAN, |model| {
                    r_squared_complex(samples.z_m(method), &model.z_m_n_s_per_m)
                });
                estimated.averaged = Averaged {
                    sigma_t_m,
                    series,
                    r2_impedance,
                };
            }
        }
    }
}

fn subject(number: usize, findings: &RecordingFindings) -> Subject {
    match findings.participant() {
        Some(id) => Subject::Participant(id.to_owned()),
        None => Subject::Recording(number),
    }
}

fn model_series(
    samples: &PreparedInstance,
    method: Method,
    estimated: &InstanceEstimate,
    conditions: &FitConditions,
    settings: &Settings,
    sigma_t_m: f64,
) -> Result<ModelledSeries, FitError> {
    let series = samples.series(method)?;
    match method {
        Method::Paper => paper::model_series(&series, conditions, &settings.paper(), sigma_t_m),
        Method::Dynamic | Method::Trial => {
            let parameters = dynamic::DynamicConstants {
                tau_s: estimated.tau_s.map_or(0.0, |(tau_s, _)| tau_s),
                z_p_n_s_per_m: estimated.z_p_n_s_per_m,
            };
            dynamic::model_series(
                &series,
                conditions,
                &settings.dynamic(),
                sigma_t_m,
                &parameters,
            )
        }
    }
}

/// Returns the model's friction with the floor of the recording's friction.
fn mu_with_floor(
    model: &ModelledSeries,
    estimated: &InstanceEstimate,
    sigma_t_m: f64,
    normal_n: &[f64],
    floor: f64,
) -> Vec<f64> {
    let Ok(contact) = Contact::new(&estimated.skin, sigma_t_m) else {
        return model.mu.clone();
    };
    let mu_at = |(&gap_m, &normal_n): (&f64, &f64)| {
        let ratio = contact.friction_ratio(gap_m, normal_n);
        estimated.mu0 * (floor + (1.0 - floor) * ratio)
    };
    model.gap_m.iter().zip(normal_n).map(mu_at).collect()
}
