//! Trials in the order of their sessions: each attempt with its verdict and a link to its estimates.

use std::path::Path;

use maud::{Markup, html};
use recording::study::event_log::ExitStatus;
use sessions::{Attempt, Session, SessionEnd};

use crate::content::{Content, Of};
use crate::number::{In, counted};

const SECONDS: In = In {
    factor: 1.0,
    decimals: 0,
};

pub(crate) fn trials(content: &Content<'_>, recordings: &[Of<'_>]) -> Markup {
    let alone: Vec<&Of<'_>> = recordings
        .iter()
        .filter(|of| of.attempt.is_none())
        .collect();
    html! {
        @for (folder, session) in &content.sessions.list {
            @match session {
                Ok(session) => (of_session(folder, session, recordings)),
                Err(reason) => {
                    p.alert { "The log of a session cannot be read: " (reason) }
                }
            }
        }
        @if !alone.is_empty() {
            h3 { "Recordings without a session's log" }
            p { "Nothing states whether these trials were accepted." }
            ul { @for of in alone { li { a href={ "#" (of.anchor()) } { (of.name()) } } } }
        }
    }
}

fn of_session(folder: &Path, session: &Session, recordings: &[Of<'_>]) -> Markup {
    // As in the recordings: if there are two studies, with the study's name.
    let mut inside = recordings.iter().filter(|of| {
        let path = of.path.canonicalize();
        path.is_ok_and(|path| path.parent() == Some(folder))
    });
    let named = inside.find_map(Of::participant);
    let title = match &session.start {
        Some(start) => format!(
            "{}, session {}",
            named.unwrap_or(&start.participant),
            start.session
        ),
        None => "Session without a start in its log".to_owned(),
    };
    let of = |attempt: &Attempt| {
        let in_folder = |of: &&Of<'_>| {
            let path = of.path.canonicalize();
            path.is_ok_and(|path| path.parent() == Some(folder))
        };
        let mut each = recordings.iter().filter(in_folder);
        each.find(|of| of.attempt.is_some_and(|own| own.label == attempt.label))
    };
    // Without the date, by which anyone who knows when a participant came could identify the person.
    let details = session.start.as_ref();
    let details = details.map(|start| format!("Protocol {}, seed {}", start.protocol, start.seed));
    html! {
        h3 { (title) }
        p.note {
            @if let Some(details) = &details { (details) "; " }
            @if session.resumed > 0 { "resumed " (counted(session.resumed, "time", "times")) "; " }
            (ended(&session.end)) "."
        }
        div.wide { table {
            thead { tr {
                th { "Attempt" } th { "Condition" } th.n { "Begun (s)" } th { "Verdict" } th { "Reasons" }
                th { "Analysed" }
            } }
            tbody { @for attempt in &session.attempts {
                @let (verdict, reasons) = attempt.verdict();
                tr {
                    th scope="row" { (attempt.label) }
                    td { (attempt.condition) }
                    td.n { (SECONDS.value(attempt.start_s)) }
                    td { (verdict) }
                    td { (reasons.join("; ")) }
                    td { @match of(attempt) {
                        Some(of) => a href={ "#" (of.anchor()) } {
                            (counted(of.result.instances.len(), "instance", "instances"))
                        },
                        None => (if attempt.is_practice() { "no: practice" } else { "no" }),
                    } }
                }
            } }
        } }
    }
}

fn ended(end: &SessionEnd) -> String {
    match end {
        SessionEnd::Unfinished => "its log does not end".to_owned(),
        SessionEnd::Stopped(status, reason) => {
            let how = match status {
                ExitStatus::Success => "completed",
                ExitStatus::Abort => "broken off by the operator",
                ExitStatus::Fail => "broken off by a fault",
            };
            reason
                .as_ref()
                .map_or_else(|| how.to_owned(), |reason| format!("{how}: {reason}"))
        }
    }
}
