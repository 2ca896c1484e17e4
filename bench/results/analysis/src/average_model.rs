//! Model with the average σ_t of a participant, at each of their instances.
//!
//! A participant's σ_t is the mean over all their instances; if the participant is unknown, over those of the recording.

use std::collections::BTreeMap;
use std::sync::Arc;

use contact::Contact;
use correlations::r_squared_complex;
use estimation::{FitConditions, FitError, ModelledSeries, dynamic, paper};
use rayon::prelude::*;

use crate::analysis_settings::Settings;
use crate::estimate::{Averaged, InstanceAnalysis, InstanceEstimate};
use crate::findings::{Analysis, RecordingFindings};
use crate::instance::PreparedInstance;
use crate::method::Method;
use crate::recording_series::RecordingSeries;
use crate::sample_statistics::{AveragedModels, ByMethod, r2_averaged};

/// Subject of the average: a participant, or the recording with this number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Subject {
    Participant(String),
    Recording(usize),
}

/// Adds to each estimate of an analysis the average σ_t of its participant by the same method, and the agreement of the model with it.
///
/// # Errors
/// The first error of `read`, which returns the series of a recording by its number.
pub(crate) fn fill<E: Send>(
    analysed: &mut Analysis,
    read: &(impl Fn(usize) -> Result<Arc<RecordingSeries>, E> + Sync),
) -> Result<(), E> {
    let settings = analysed.settings;
    let mut sigmas_m = BTreeMap::<(Subject, &str), Vec<f64>>::new();
    for (number, findings) in analysed.numbered_findings() {
        for estimate in findings
            .instances
            .iter()
            .flat_map(InstanceAnalysis::estimates)
        {
            sigmas_m
                .entry((subject(number, findings), estimate.method.name()))
                .or_default()
                .push(estimate.estimate.sigma_t_m());
        }
    }
    let mut recordings: Vec<(usize, &mut RecordingFindings)> =
        analysed.numbered_findings_mut().collect();
    recordings
        .par_iter_mut()
        .try_for_each(|(number, findings)| {
            if findings.instances.is_empty() {
                return Ok(());
            }
            let subject = subject(*number, findings);
            let average_m = |name| {
                let values_m = sigmas_m.get(&(subject.clone(), name));
                values_m.map_or(f64::NAN, |values_m| {
                    values_m.iter().sum::<f64>() / values_m.len() as f64
                })
            };
            let series = read(*number)?;
            fill_recording(findings, &series, &settings, average_m);
            Ok(())
        })
}

fn fill_recording(
    findings: &mut RecordingFindings,
    series: &RecordingSeries,
    settings: &Settings,
    average_m: impl Fn(&'static str) -> f64,
) {
    for instance in &mut findings.instances {
        for method in Method::ALL {
            if let Some(estimate) = instance.fit_mut(method) {
                estimate.averaged.sigma_t_m = average_m(method.name());
            }
        }
    }
    let models = models(findings, series, settings);
    let instances = findings.instances.iter_mut().zip(&series.instances);
    for ((instance, sampled), models) in instances.zip(&models) {
        for method in Method::ALL {
            let Some(estimate) = instance.fit_mut(method) else {
                continue;
            };
            let z_m = sampled.samples.z_m(method);
            let model = models.get(method).as_ref();
            estimate.averaged.r2_impedance = model.map_or(f64::NAN, |model| {
                r_squared_complex(z_m, &model.z_m_n_s_per_m)
            });
        }
    }
    for method in Method::ALL {
        let r2 = r2_averaged(&findings.instances, &series.instances, &models, method);
        findings.sample_statistics.get_mut(method).r2_averaged = r2;
    }
}

/// Returns the models of each instance of a recording with the average σ_t of its participant.
#[must_use]
pub fn models(
    findings: &RecordingFindings,
    series: &RecordingSeries,
    settings: &Settings,
) -> Vec<AveragedModels> {
    let Some(shared_conditions) = findings.conditions(settings) else {
        return Vec::new();
    };
    let floor = findings
        .trial
        .as_ref()
        .and_then(|shared| shared.friction_floor);
    let floor = floor.map(|floor| floor.value);
    let instances = findings.instances.iter().zip(&series.instances);
    let models = instances.map(|(instance, sampled)| {
        ByMethod::new(|method| {
            let estimated = instance.fit(method)?;
            let samples = &sampled.samples;
            let conditions = FitConditions {
                assumed: estimated.skin,
                ..shared_conditions
            };
            let Averaged { sigma_t_m, .. } = estimated.averaged;
            let model = model_series(samples, method, estimated, &conditions, settings, sigma_t_m);
            let mut model = model.ok()?;
            if let (Method::Trial, Some(floor)) = (method, floor) {
                let normal_n = samples.finger_force_n();
                model.mu = mu_with_floor(&model, estimated, sigma_t_m, normal_n, floor);
            }
            Some(model)
        })
    });
    models.collect()
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
