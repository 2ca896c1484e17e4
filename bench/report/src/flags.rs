//! Cautions for the reader: warnings, verdicts of fits, misfit of the model.

use maud::{Markup, html};
use serde_json::Value;

use crate::content::Of;
use crate::number::counted;

/// Verdict of a fit without problems.
const SOUND: &str = "converged";

pub(crate) fn flags(recordings: &[Of<'_>]) -> Markup {
    let misfits = |of: &&Of<'_>| of.result.trial.as_ref().and_then(|trial| trial.misfit());
    let judged = recordings.iter().filter(|of| misfits(of).is_some()).count();
    let misfit: Vec<&Of<'_>> = recordings
        .iter()
        .filter(|of| misfits(of) == Some(true))
        .collect();
    let warned: Vec<&Of<'_>> = recordings
        .iter()
        .filter(|of| !of.result.warnings.is_empty())
        .collect();
    let verdicts = verdicts(recordings);
    html! {
        h3 { "Does the model fit?" }
        @if judged == 0 {
            p { "The results do not say: the version of the program that analysed these recordings did not judge it." }
        } @else if misfit.is_empty() {
            p { "It was held to fit in all " (counted(judged, "recording", "recordings")) " where that was judged." }
        } @else {
            p.alert {
                "It was held " b { "not" } " to fit in these recordings, of " (judged)
                " judged. Their values by " b { "trial" } " are not to be relied on, no interval is given for them, and they are left \
                 out of the " a href="#skin" { "participants' skin" } "."
            }
            ul { @for of in &misfit { li {
                a href={ "#" (of.anchor()) } { (of.name()) }
                @for sign in of.result.trial.iter().flat_map(|trial| trial.signs()) { "; " (sign) }
                @for (name, value) in evidence(of) { "; " code { (name) " = " (value) } }
            } } }
        }
        h3 { "Warnings of the analysis" }
        @if warned.is_empty() { p { "None." } } @else {
            @for of in warned {
                p { a href={ "#" (of.anchor()) } { (of.name()) } }
                ul { @for warning in &of.result.warnings { li { (warning) } } }
            }
        }
        h3 { "Fits that are not simply converged" }
        @if verdicts.is_empty() { p { "None." } } @else {
            div.wide { table {
                thead { tr { th { "Recording" } th { "Method" } th { "Verdict" } th { "Instances" } } }
                tbody { @for verdict in &verdicts { tr {
                    th scope="row" { (verdict.recording) } td { (verdict.method) } td { (verdict.verdict) }
                    td { (verdict.instances) }
                } } }
            } }
        }
    }
}

/// Returns the entries of the results about misfit other than its signs, also those of later versions.
fn evidence<'a>(of: &Of<'a>) -> Vec<(&'a String, &'a Value)> {
    let parameters = of.result.trial.iter().flat_map(|trial| &trial.parameters);
    parameters
        .filter(|(name, value)| name.contains("misfit") && !value.is_boolean() && *name != "misfit")
        .collect()
}

/// Verdict on some fits of a recording.
struct Verdict {
    recording: String,
    method: &'static str,
    verdict: String,
    /// Numbers of the instances, or a note that all were fitted together.
    instances: String,
}

fn verdicts(recordings: &[Of<'_>]) -> Vec<Verdict> {
    let mut found = Vec::new();
    for of in recordings {
        if let Some(trial) = of
            .result
            .trial
            .as_ref()
            .filter(|trial| trial.verdict != SOUND)
        {
            found.push(Verdict {
                recording: of.name(),
                method: "trial",
                verdict: trial.verdict.clone(),
                instances: "all together".to_owned(),
            });
        }
        let mut each: Vec<(&'static str, &str, Vec<String>)> = Vec::new();
        for (instance, number) in of.result.instances.iter().zip(1..) {
            let alone = instance
                .estimates()
                .filter(|(method, _)| *method != "trial");
            for (method, estimate) in alone.filter(|(_, of)| of.verdict != SOUND) {
                // The rest of the verdict differs from instance to instance.
                let verdict = estimate.verdict.split(';').next().unwrap_or_default();
                match each.iter_mut().find(|of| of.0 == method && of.1 == verdict) {
                    Some(of) => of.2.push(number.to_string()),
                    None => each.push((method, verdict, vec![number.to_string()])),
                }
            }
        }
        found.extend(
            each.into_iter()
                .map(|(method, verdict, instances)| Verdict {
                    recording: of.name(),
                    method,
                    verdict: verdict.to_owned(),
                    instances: instances.join(", "),
                }),
        );
    }
    found
}
