//! Cautions for the reader: warnings, verdicts of fits, misfit of the model.

use analysis::method::Method;
use maud::{Markup, html};

use crate::content::RecordingEntry;
use crate::instance::{self, MethodEstimate};
use crate::number::count_text;
use crate::recording_results::Trial;

/// Verdict of a fit without problems.
const CONVERGED: &str = "converged";

pub(crate) fn flags(recordings: &[RecordingEntry<'_>]) -> Markup {
    let judged = recordings
        .iter()
        .filter_map(|recording| Some((recording, recording.result.trial.as_ref()?)));
    let n_judged = judged.clone().count();
    let (misfits, fitted): (Vec<_>, Vec<_>) = judged.partition(|(_, trial)| trial.model_misfit);
    let outside_published: Vec<(&RecordingEntry<'_>, &Trial)> = fitted
        .into_iter()
        .filter(|(_, trial)| !trial.misfit_within_laws.is_empty())
        .collect();
    let warned_recordings: Vec<&RecordingEntry<'_>> = recordings
        .iter()
        .filter(|recording| !recording.result.warnings.is_empty())
        .collect();
    let (misfit_rows, verdicts) = (instance_misfits(recordings), verdicts(recordings));
    html! {
        h3 { "Fit of the model" }
        @if n_judged == 0 {
            p { "The fit was not tested: no recording has an estimate by " b { "trial" } ", which fits all instances together." }
        } @else if misfits.is_empty() {
            p { "The model fits every recording in which the fit was tested (" (count_text(n_judged, "recording", "recordings")) ")." }
        } @else {
            p.alert {
                "The model does " b { "not" } " fit these recordings, of " (n_judged)
                " tested. Their values by " b { "trial" } " are unreliable: they have no intervals, and the "
                a href="#skin" { "skin of the participants" } " omits them."
            }
            ul { @for (recording, trial) in &misfits { li {
                a href={ "#" (recording.anchor()) } { (recording.name()) }
                @for sign in &trial.misfit { "; " (sign) }
            } } }
        }
        @if !outside_published.is_empty() {
            p {
                "The published laws alone do not fit " (outside_published.len()) " of them: these have no interval "
                i.within { "within the laws" } ", and the doubt about the laws explains them."
            }
            ul { @for (recording, trial) in &outside_published { li {
                a href={ "#" (recording.anchor()) } { (recording.name()) }
                @for sign in &trial.misfit_within_laws { "; " (sign) }
            } } }
        }
        h3 { "Instances outside the laws of their method" }
        @if misfit_rows.is_empty() { p { "None." } } @else {
            p {
                b { "paper" } " and " b { "dynamic" } " assume the constants of the skin. The values of these instances have no errors."
            }
            div.wide { table {
                thead { tr { th { "Recording" } th { "Method" } th { "Instances" } th { "Signs of the first" } } }
                tbody { @for row in &misfit_rows { tr {
                    th scope="row" { (row.recording) } td { (row.method.name()) } td { (row.instances.join(", ")) }
                    td { (row.signs) }
                } } }
            } }
        }
        h3 { "Warnings of the analysis" }
        @if warned_recordings.is_empty() { p { "None." } } @else {
            @for recording in warned_recordings {
                p { a href={ "#" (recording.anchor()) } { (recording.name()) } }
                ul { @for warning in &recording.result.warnings { li { (warning) } } }
            }
        }
        h3 { "Fits with a verdict other than converged" }
        @if verdicts.is_empty() { p { "None." } } @else {
            div.wide { table {
                thead { tr { th { "Recording" } th { "Method" } th { "Verdict" } th { "Instances" } } }
                tbody { @for verdict in &verdicts { tr {
                    th scope="row" { (verdict.recording) } td { (verdict.method.name()) } td { (verdict.verdict) }
                    td { (verdict.instances) }
                } } }
            } }
        }
    }
}

/// Instances of a recording that do not follow the laws of a method.
struct InstanceMisfits {
    recording: String,
    method: Method,
    /// Numbers of the instances.
    instances: Vec<String>,
    /// Signs of the first of them.
    signs: String,
}

fn instance_misfits(recordings: &[RecordingEntry<'_>]) -> Vec<InstanceMisfits> {
    let mut rows: Vec<InstanceMisfits> = Vec::new();
    for recording in recordings {
        let mut recording_rows: Vec<InstanceMisfits> = Vec::new();
        for (instance, number) in recording.result.instances.iter().zip(1..) {
            let outside = instance::estimates(instance).filter(|estimated| {
                estimated.method != Method::Trial && estimated.estimate.model_misfit
            });
            for MethodEstimate {
                method, estimate, ..
            } in outside
            {
                match recording_rows.iter_mut().find(|row| row.method == method) {
                    Some(row) => row.instances.push(number.to_string()),
                    None => recording_rows.push(InstanceMisfits {
                        recording: recording.name(),
                        method,
                        instances: vec![number.to_string()],
                        signs: estimate.misfit.join("; "),
                    }),
                }
            }
        }
        rows.extend(recording_rows);
    }
    rows
}

/// Verdict on some fits of a recording.
struct Verdict {
    recording: String,
    method: Method,
    verdict: String,
    /// Numbers of the instances, or a note that all were fitted together.
    instances: String,
}

fn verdicts(recordings: &[RecordingEntry<'_>]) -> Vec<Verdict> {
    let mut verdicts = Vec::new();
    for recording in recordings {
        if let Some(trial) = recording
            .result
            .trial
            .as_ref()
            .filter(|trial| trial.verdict != CONVERGED)
        {
            verdicts.push(Verdict {
                recording: recording.name(),
                method: Method::Trial,
                verdict: trial.verdict.clone(),
                instances: "all together".to_owned(),
            });
        }
        let mut groups: Vec<(Method, &str, Vec<String>)> = Vec::new();
        for (instance, number) in recording.result.instances.iter().zip(1..) {
            let separate_estimates = instance::estimates(instance).filter(|estimated| {
                estimated.method != Method::Trial && estimated.estimate.verdict != CONVERGED
            });
            for MethodEstimate {
                method, estimate, ..
            } in separate_estimates
            {
                // The rest of the verdict differs from instance to instance.
                let verdict = estimate.verdict.split(';').next().unwrap_or_default();
                match groups
                    .iter_mut()
                    .find(|group| group.0 == method && group.1 == verdict)
                {
                    Some(group) => group.2.push(number.to_string()),
                    None => groups.push((method, verdict, vec![number.to_string()])),
                }
            }
        }
        verdicts.extend(
            groups
                .into_iter()
                .map(|(method, verdict, instances)| Verdict {
                    recording: recording.name(),
                    method,
                    verdict: verdict.to_owned(),
                    instances: instances.join(", "),
                }),
        );
    }
    verdicts
}
