//! Estimates of each trial, from the findings of an analysis.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use contact::uncertain::{LogUncertain, Uncertain};
use estimation::trial::SharedFit;

use super::{CheckedTrial, Condition, Estimate, LawCheck, Quantities, check};
use analysis::findings::{Analysis, RecordingFindings};
use analysis::within_laws::WithinLaws;

/// Returns the check of each participant with trials under two or more conditions, by name.
#[must_use]
pub fn law_checks(analysed: &Analysis) -> Vec<LawCheck> {
    let mut people = BTreeMap::<&str, (Vec<FittedTrial<'_>>, usize)>::new();
    for recording in &analysed.recordings {
        let Some(participant) = &recording.participant else {
            continue;
        };
        let (trials, n_left_out) = people.entry(participant).or_default();
        let findings = recording.findings.as_ref().ok();
        match findings.and_then(FittedTrial::new) {
            Some(trial) => trials.push(trial),
            None => *n_left_out += 1,
        }
    }
    let checks = people
        .into_iter()
        .filter_map(|(participant, (trials, n_left_out))| {
            let references = References::new(&trials);
            let trials: Vec<_> = trials
                .iter()
                .map(|trial| trial.checked(&references))
                .collect();
            check(participant, &trials, n_left_out)
        });
    checks.collect()
}

/// Recording with a usable fit of all instances, by the published laws, which are checked: errors of the laws in doubt are common to
/// all conditions and would hide a difference.
struct FittedTrial<'a> {
    condition: Condition,
    shared: &'a SharedFit,
    instances: Vec<&'a WithinLaws>,
    /// Logarithm of the mean normal force, N.
    ln_normal_n: f64,
    /// Mean over the instances of the logarithm of their mean gap, m.
    ln_gap_m: f64,
}

/// Means over a participant's trials.
struct References {
    ln_normal_n: f64,
    ln_gap_m: f64,
}

impl References {
    fn new(trials: &[FittedTrial<'_>]) -> Self {
        let trial_mean = |value: fn(&FittedTrial<'_>) -> f64| mean(trials.iter().map(value));
        Self {
            ln_normal_n: trial_mean(|trial| trial.ln_normal_n),
            ln_gap_m: trial_mean(|trial| trial.ln_gap_m),
        }
    }
}

impl<'a> FittedTrial<'a> {
    /// Returns the trial of a recording; `None` without a usable fit, if the laws do not fit, or if a setting is unknown.
    fn new(findings: &'a RecordingFindings) -> Option<Self> {
        let shared = findings.fit_within_laws()?;
        let condition = condition(findings);
        if !condition.is_known() {
            return None;
        }
        let instances = findings.instances.iter();
        let instances: Vec<_> = instances
            .filter_map(|instance| instance.within_laws.as_ref())
            .collect();
        if instances.is_empty() {
            return None;
        }
        let gaps = instances.iter().map(|instance| instance.mean_gap_m.ln());
        Some(Self {
            condition,
            shared,
            ln_normal_n: mean(findings.instances.iter().map(|instance| instance.normal_n)).ln(),
            ln_gap_m: mean(gaps),
            instances,
        })
    }

    fn checked(&self, references: &References) -> CheckedTrial {
        let shared = self.shared;
        // S grows with the force to the power of one exponent, τ with the gap to the power of another.
        let force_ratio = self.ln_normal_n - references.ln_normal_n;
        let gap_ratio = self.ln_gap_m - references.ln_gap_m;
        let omega = TAU * self.condition.carrier_hz;
        let estimates = Quantities {
            ln_sigma_t: self.instance_mean(|estimate| {
                (estimate.sigma_t_m.value.ln(), estimate.sigma_t_m.ln_std)
            }),
            ln_contact_area: at_reference(
                shared.contact_area_m2,
                shared.area_exponent,
                force_ratio,
            ),
            ln_tau: at_reference(shared.tau_s, shared.lag_exponent, gap_ratio),
            re_z_t_n_s_per_m: self.instance_mean(|estimate| {
                (estimate.z_t_n_s_per_m.re, estimate.z_t_std_n_s_per_m.re)
            }),
            im_z_t_over_omega_kg: self.instance_mean(|estimate| {
                let std = estimate.z_t_std_n_s_per_m.im / omega;
                (estimate.z_t_n_s_per_m.im / omega, std)
            }),
        };
        CheckedTrial {
            condition: self.condition,
            estimates,
        }
    }

    /// Returns the mean over the instances of a value with its standard error. Most of the error comes from the parameters that
    /// the instances share, so the mean has the mean error.
    fn instance_mean(&self, value: impl Fn(&WithinLaws) -> (f64, f64)) -> Option<Estimate> {
        let values: Vec<(f64, f64)> = self
            .instances
            .iter()
            .map(|estimate| value(estimate))
            .filter(|(value, _)| value.is_finite())
            .collect();
        Estimate::new(
            mean(values.iter().map(|(value, _)| *value)),
            mean(values.iter().map(|(_, std)| *std)),
        )
    }
}

/// Returns the logarithm of a parameter that grows by a power law, at the reference of the law; `ln_ratio` is the logarithm of the
/// trial's place over the reference.
fn at_reference(parameter: LogUncertain, exponent: Uncertain, ln_ratio: f64) -> Option<Estimate> {
    Estimate::new(
        parameter.value.ln() - exponent.value * ln_ratio,
        parameter.ln_std.hypot(exponent.std * ln_ratio),
    )
}

/// Returns the settings of a recording: the drive level as measured, the frequencies as stated.
fn condition(findings: &RecordingFindings) -> Condition {
    let modulation = findings.manifest.modulation();
    let index = modulation.map_or(f64::NAN, |modulation| modulation.index);
    let peak_v = mean(
        findings
            .explorations
            .iter()
            .map(|exploration| exploration.drive_peak_v),
    );
    Condition {
        drive_v: peak_v / (1.0 + index),
        modulation_hz: modulation.map_or(f64::NAN, |modulation| modulation.frequency_hz),
        carrier_hz: findings.carrier_hz().unwrap_or(f64::NAN),
    }
}

/// Returns the mean; NaN without values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    sum / n
}
