//! Excluded recordings and rejected stretches.

use std::collections::BTreeMap;

use attempts::{AttemptAccount, OmittedAttempt};
use maud::{Markup, html};
use study::exclusions::Excluded;

use crate::content::RecordingEntry;
use crate::number::{NumberFormat, count_text};
use crate::results::Results;

const SECONDS: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 2,
};

pub(crate) fn omissions(results: &Results<'_>, recordings: &[RecordingEntry<'_>]) -> Markup {
    // By kind: the numbers of a reason differ from stretch to stretch.
    let mut reasons: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for recording in recordings {
        let mut recording_reasons: Vec<&str> = Vec::new();
        for rejection in &recording.result.rejected {
            let entry = reasons.entry(&rejection.kind).or_default();
            entry.0 += 1;
            if !recording_reasons.contains(&rejection.kind.as_str()) {
                recording_reasons.push(&rejection.kind);
                entry.1 += 1;
            }
        }
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, (stretches, _))| std::cmp::Reverse(*stretches));
    html! {
        (attempt_table(results.attempts))
        h3 { "Excluded by decision" }
        @if !results.exclusions_overridden.is_empty() {
            p.alert {
                "These decisions were overridden (" code { "--include-excluded" } "): the recordings were analysed nevertheless."
            }
            (decisions(results.exclusions_overridden))
        } @else if results.excluded.is_empty() {
            p { "None." }
        } @else {
            (decisions(results.excluded))
        }
        h3 { "Rejected by rule" }
        @if reasons.is_empty() {
            p { "None." }
        } @else {
            div.wide { table {
                thead { tr { th { "Reason" } th.n { "Stretches" } th.n { "In recordings" } } }
                tbody { @for (reason, (stretches, n_recordings)) in &reasons { tr {
                    th scope="row" { (reason) } td.n { (stretches) } td.n { (n_recordings) }
                } } }
            } }
            details {
            summary { "Times of the stretches, s from the beginning of the recording" }
            ul { @for recording in recordings.iter().filter(|recording| !recording.result.rejected.is_empty()) {
                li {
                    a href={ "#" (recording.anchor()) } { (recording.name()) } ", "
                    (count_text(recording.result.rejected.len(), "stretch", "stretches")) ": "
                    span.note { @for (index, (reason, times)) in stretches_by_reason(recording).iter().enumerate() {
                        @if index > 0 { "; " }
                        (reason) ": " (times.join(", "))
                    } }
                }
            } }
            }
        }
    }
}

/// Returns the attempts that were not analysed because of their standing in the sessions' logs.
fn attempt_table(attempts: &AttemptAccount) -> Markup {
    html! {
        h3 { "Attempts" }
        p {
            "According to the logs, " (count_text(attempts.accepted, "trial was", "trials were")) " accepted; "
            (count_text(attempts.analysed, "recording was", "recordings were")) " analysed"
            @if attempts.not_accepted > 0 { ", " (attempts.not_accepted) " of them from trials that were not accepted" }
            "."
        }
        @for session in &attempts.empty_sessions { p { "A session has no accepted trial. " (session) "." } }
        @for log in &attempts.unread_logs { p.alert { "A log cannot be read. " (log) } }
        @if attempts.missed().next().is_some() {
            p.alert { "Accepted trials are missing: they could not be analysed." }
        }
        @if !attempts.left_out.is_empty() {
            div.wide { table {
                thead { tr { th { "Attempt" } th { "Verdict" } th { "Not analysed because" } } }
                tbody { @for attempt in &attempts.left_out { tr {
                    th scope="row" { (name(attempt)) }
                    td { @match attempt.standing { Some(standing) => (standing), None => "not known" } }
                    td { (attempt.because) }
                } } }
            } }
        }
    }
}

/// Returns the last names of the path of an attempt's folder.
fn name(attempt: &OmittedAttempt) -> String {
    let path = attempt.path.display().to_string();
    let names: Vec<&str> = path.rsplit('/').take(3).collect();
    names.into_iter().rev().collect::<Vec<_>>().join("/")
}

fn decisions(exclusions: &[Excluded]) -> Markup {
    html! {
        div.wide { table {
            thead { tr {
                th { "Participant" } th { "Session" } th { "Trial" } th { "Reason" } th { "Decided by" } th { "Date" }
                th.n { "Recordings" }
            } }
            tbody { @for Excluded { exclusion, recordings, .. } in exclusions { tr {
                th scope="row" { (exclusion.participant) } td { (exclusion.session) } td { (exclusion.trial) }
                td { (exclusion.reason) } td { (exclusion.by) } td { (exclusion.date.as_deref().unwrap_or("not stated")) }
                td.n { (recordings.len()) }
            } } }
        } }
    }
}

/// Returns the rejected stretches of a recording, grouped by reason.
fn stretches_by_reason<'a>(recording: &RecordingEntry<'a>) -> Vec<(&'a str, Vec<String>)> {
    let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
    for rejection in &recording.result.rejected {
        let [from, to] = [rejection.start_s, rejection.end_s].map(|time| SECONDS.value(Some(time)));
        let range = format!("{from}–{to}");
        match reasons
            .iter_mut()
            .find(|(reason, _)| *reason == rejection.reason)
        {
            Some((_, stretches)) => stretches.push(range),
            None => reasons.push((&rejection.reason, vec![range])),
        }
    }
    reasons
}
