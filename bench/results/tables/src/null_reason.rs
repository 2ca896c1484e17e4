//! Reasons why numbers of a row are empty that are not empty in every such row.

use std::collections::BTreeMap;
use std::sync::Arc;

use analysis::estimate::InstanceEstimate;
use analysis::findings::{RecordingFindings, rejection_counts};
use analysis::flaw::Flaw;
use analysis::method::Method;
use descriptive::{Group, Quantity};

use crate::column::Columns;
use crate::rows::{InstanceRow, SampleRow};
use crate::trial_entry::TrialEntry;

/// Adds the column of the reasons.
pub(crate) fn column<R>(columns: &mut Columns<'_, R>, reasons: impl Fn(&R) -> Vec<String>) {
    let empty: Arc<str> = "".into();
    columns.text(
        "null_because",
        "reasons why numbers of the row are empty, each after the columns concerned, joined by `; `; empty if no number is withheld",
        |row| match reasons(row) {
            reasons if reasons.is_empty() => Arc::clone(&empty),
            reasons => reasons.join("; ").into(),
        },
    );
}

/// Returns the reasons of an instance by a method.
pub(crate) fn of_instance(row: &InstanceRow<'_>) -> Vec<String> {
    let Some(estimate) = row.estimate() else {
        return vec![format!("estimates: {}", without_estimate(row))];
    };
    let mut reasons = Vec::new();
    reasons.extend(sigma_t(
        estimate,
        "sigma_t_m, gap_at_crest_m, delta_gap_m, delta_squeeze_n",
    ));
    if estimate.sigma_t().is_ok() {
        let doubt = doubt(row).map(|doubt| format!("gap_at_crest_m: {doubt}"));
        reasons.extend(doubt);
    }
    reasons.extend(average(estimate, "averaged_sigma_t_m"));
    if estimate.spearman_mu.is_none() {
        reasons
            .push("spearman_mu: the measured or the estimated friction does not vary".to_owned());
    }
    if row.trial().is_some() && row.instance.within_laws.is_none() {
        let reason = without_laws(row.findings());
        reasons.push(format!("columns with within_laws: {reason}"));
    }
    reasons
}

/// Returns the reasons of a sample.
pub(crate) fn of_sample(sample: &SampleRow<'_>) -> Vec<String> {
    let Some(estimate) = sample.row.estimate() else {
        return Vec::new();
    };
    let mut reasons = Vec::new();
    let columns = "gap_m, film_force_n";
    match sigma_t(estimate, columns) {
        Some(reason) => reasons.push(reason),
        None if sample.estimate.contact.gap_m[sample.index].is_nan() => {
            reasons.push(format!(
                "{columns}, mu: no gap explains the impedance of this sample"
            ));
        }
        None => {}
    }
    match average(estimate, "columns with averaged") {
        Some(reason) => reasons.push(reason),
        None if !sample.has_average() => reasons.push(
            "columns with averaged: a contact with the average σ_t does not carry the force of this instance"
                .to_owned(),
        ),
        None => {}
    }
    reasons
}

/// Returns the reasons of an exploration.
pub(crate) fn of_exploration(findings: &RecordingFindings, samples: usize) -> Vec<String> {
    let mut reasons = Vec::new();
    if samples == 0 {
        reasons.push("mu, normal_n: no sample in which the finger presses".to_owned());
    }
    if findings.vibration.is_none() {
        reasons.push("amplitude_m: only forces were recorded".to_owned());
    }
    reasons
}

/// Returns the reasons of a group of instances, with the gap by `gap_method`, given the trials of the group.
pub(crate) fn of_group(
    group: &Group,
    trials: &[&TrialEntry<'_>],
    gap_method: Method,
) -> Vec<String> {
    if group.n_instances == 0 {
        let reasons = trials.iter().map(|trial| without_instances(trial.findings));
        return vec![format!("means: {}", counted(reasons))];
    }
    if !group.mean(Quantity::Gap).value.is_nan() {
        return Vec::new();
    }
    let instances = trials.iter().flat_map(|trial| trial.rows(gap_method));
    let reasons = instances.map(|row| match row.estimate() {
        None => without_estimate(&row),
        Some(estimate) => match estimate.sigma_t() {
            Err(error) => error.to_string(),
            Ok(_) => doubt(&row)
                .unwrap_or_else(|| "no gap explains the impedance at the crest".to_owned()),
        },
    });
    vec![format!("gap_at_crest_m: {}", counted(reasons))]
}

/// Returns the sign that the model of a row by `trial` does not hold.
fn doubt(row: &InstanceRow<'_>) -> Option<String> {
    let sign = row.trial()?.misfit.first()?;
    Some(format!("the model does not hold: {sign}"))
}

fn sigma_t(estimate: &InstanceEstimate, columns: &str) -> Option<String> {
    let error = estimate.sigma_t().err()?;
    Some(format!("{columns}: {error}"))
}

fn average(estimate: &InstanceEstimate, columns: &str) -> Option<String> {
    let error = estimate.averaged.sigma_t_m().err()?;
    Some(format!("{columns}: {error}"))
}

/// Returns the reason why an instance has no estimate by the method of its row.
fn without_estimate(row: &InstanceRow<'_>) -> String {
    let verdict = match row.method {
        Method::Paper => Some(&row.instance.paper.verdict),
        Method::Dynamic => Some(&row.instance.dynamic.verdict),
        Method::Trial => row.findings().trial.as_ref().map(|fit| &fit.verdict),
    };
    let method = row.method.name();
    match verdict {
        Some(verdict) => format!("`{method}` gave no usable fit: {verdict}"),
        None => format!("`{method}` cannot be fitted to the instances of the recording"),
    }
}

/// Returns the reason why there are no estimates by the published laws, of a recording that `trial` estimates.
fn without_laws(findings: &RecordingFindings) -> String {
    let fits = [&findings.trial, &findings.within_laws];
    let mut signs = fits.into_iter().flatten().flat_map(|fit| &fit.misfit);
    let verdict = findings.within_laws.as_ref().map(|fit| &fit.verdict);
    match (signs.next(), verdict) {
        (Some(sign), _) => format!("the published laws do not hold: {sign}"),
        (None, Some(verdict)) => format!("no usable fit by the published laws: {verdict}"),
        (None, None) => "no fit by the published laws".to_owned(),
    }
}

/// Returns the reason why a recording has no instance.
fn without_instances(findings: &RecordingFindings) -> String {
    if let Some(reason) = findings.withheld_reason() {
        let flaw = findings
            .flaws
            .iter()
            .find(|flaw| matches!(flaw, Flaw::Implausible(found) if found.spoils_estimates()));
        return flaw.map_or(reason.clone(), |flaw| format!("{reason}: {flaw}"));
    }
    let is_cause = |flaw: &&Flaw| {
        matches!(
            flaw,
            Flaw::Missing(_) | Flaw::Unloaded(_) | Flaw::NoExploration
        )
    };
    if let Some(flaw) = findings.flaws.iter().find(is_cause) {
        return flaw.to_string();
    }
    let kinds = findings.rejected.iter().map(|stretch| &*stretch.kind);
    match rejection_counts(kinds).as_slice() {
        [] => "no stretch of rising amplitude in an exploration".to_owned(),
        counts => {
            let counts = counts.iter().map(|(kind, n)| format!("{kind} ({n})"));
            let list = counts.collect::<Vec<_>>().join(", ");
            format!("every stretch was rejected: {list}")
        }
    }
}

/// Returns the distinct reasons, each with its number if several share it.
fn counted(reasons: impl IntoIterator<Item = String>) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for reason in reasons {
        *counts.entry(reason).or_default() += 1;
    }
    let texts = counts.into_iter().map(|(reason, n)| match n {
        1 => reason,
        n => format!("{reason} ({n} times)"),
    });
    texts.collect::<Vec<_>>().join("; ")
}
