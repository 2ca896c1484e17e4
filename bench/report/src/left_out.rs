//! Excluded recordings and rejected stretches.

use std::collections::BTreeMap;

use maud::{Markup, html};

use crate::content::Of;
use crate::number::{In, counted};
use crate::results::{Excluded, Results};

const SECONDS: In = In {
    factor: 1.0,
    decimals: 2,
};

pub(crate) fn left_out(results: &Results, recordings: &[Of<'_>]) -> Markup {
    let mut reasons: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for of in recordings {
        let mut seen: Vec<&str> = Vec::new();
        for rejected in &of.result.rejected {
            let entry = reasons.entry(&rejected.reason).or_default();
            entry.0 += 1;
            if !seen.contains(&rejected.reason.as_str()) {
                seen.push(&rejected.reason);
                entry.1 += 1;
            }
        }
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, (stretches, _))| std::cmp::Reverse(*stretches));
    html! {
        (by_standing(results))
        h3 { "Excluded by decision" }
        @if !results.exclusions_overridden.is_empty() {
            p.alert {
                "These decisions were overridden (" code { "--include-excluded" } "): the recordings were analysed all the same."
            }
            (decisions(&results.exclusions_overridden))
        } @else if results.excluded.is_empty() {
            p { "Nothing." }
        } @else {
            (decisions(&results.excluded))
        }
        h3 { "Rejected by rule" }
        @if reasons.is_empty() {
            p { "No stretch was rejected." }
        } @else {
            div.wide { table {
                thead { tr { th { "Reason" } th.n { "Stretches" } th.n { "In recordings" } } }
                tbody { @for (reason, (stretches, of)) in &reasons { tr {
                    th scope="row" { (reason) } td.n { (stretches) } td.n { (of) }
                } } }
            } }
            p { "Where, s from the recording's beginning:" }
            ul { @for of in recordings.iter().filter(|of| !of.result.rejected.is_empty()) {
                li {
                    a href={ "#" (of.anchor()) } { (of.name()) } ", "
                    (counted(of.result.rejected.len(), "stretch", "stretches")) ": "
                    span.note { @for (at, (reason, times)) in by_reason(of).iter().enumerate() {
                        @if at > 0 { "; " }
                        (reason) ": " (times.join(", "))
                    } }
                }
            } }
        }
    }
}

/// Returns the attempts that were not analysed because of their standing in the sessions' logs.
fn by_standing(results: &Results) -> Markup {
    let Some(attempts) = &results.attempts else {
        return html! {};
    };
    html! {
        h3 { "Attempts" }
        p {
            (counted(attempts.accepted, "trial was", "trials were")) " accepted by the logs, "
            (counted(attempts.analysed, "recording", "recordings")) " analysed"
            @if attempts.not_accepted > 0 { ", " (attempts.not_accepted) " of them of trials that were not accepted" }
            "."
        }
        @for log in &attempts.unread_logs { p.alert { "A log cannot be read. " (log) } }
        @if attempts.left_out.iter().any(|of| of.is_missed()) {
            p.alert { "Accepted trials are missed: they could not be analysed." }
        }
        @if !attempts.left_out.is_empty() {
            div.wide { table {
                thead { tr { th { "Attempt" } th { "Standing" } th { "Not analysed because" } } }
                tbody { @for of in &attempts.left_out { tr {
                    th scope="row" { (of.name()) } td { (of.standing.as_deref().unwrap_or("not known")) }
                    td { (of.because) }
                } } }
            } }
        }
    }
}

fn decisions(of: &[Excluded]) -> Markup {
    html! {
        div.wide { table {
            thead { tr {
                th { "Participant" } th { "Session" } th { "Trial" } th { "Why" } th { "Decided by" } th { "On" }
                th.n { "Recordings" }
            } }
            tbody { @for of in of { tr {
                th scope="row" { (of.participant) } td { (of.session) } td { (of.trial) } td { (of.reason) }
                td { (of.by) } td { (of.date.as_deref().unwrap_or("not stated")) } td.n { (of.recordings.len()) }
            } } }
        } }
    }
}

/// Returns the rejected stretches of a recording, grouped by reason.
fn by_reason<'a>(of: &Of<'a>) -> Vec<(&'a str, Vec<String>)> {
    let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
    for rejected in &of.result.rejected {
        let [from, to] = [rejected.start_s, rejected.end_s].map(|time| SECONDS.value(Some(time)));
        let times = format!("{from}–{to}");
        match reasons
            .iter_mut()
            .find(|(reason, _)| *reason == rejected.reason)
        {
            Some((_, of)) => of.push(times),
            None => reasons.push((&rejected.reason, vec![times])),
        }
    }
    reasons
}
