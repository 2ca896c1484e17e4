//! Trials in the order of their sessions: each attempt with its verdict and a link to its estimates.

use std::path::Path;

use maud::{Markup, html};
use recording::study::event_log::ExitStatus;
use study::sessions::{Attempt, LoggedSession, SessionEnd};

use crate::content::{RecordingEntry, ReportContent};
use crate::number::{NumberFormat, count_text};

/// Explanation of an attempt without an outcome in its log.
const UNSETTLED: &str = "the program ended during this attempt, before its verdict; a resumed session repeats the trial";

const SECONDS: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 0,
};

pub(crate) fn trials(content: &ReportContent<'_>, recordings: &[RecordingEntry<'_>]) -> Markup {
    let unlogged_recordings: Vec<&RecordingEntry<'_>> = recordings
        .iter()
        .filter(|recording| recording.attempt.is_none())
        .collect();
    html! {
        @for (folder, session) in &content.sessions.list {
            @match session {
                Ok(session) => (session_section((folder, session), content, recordings)),
                Err(reason) => {
                    p.alert { "The log of a session cannot be read: " (reason) }
                }
            }
        }
        @if !unlogged_recordings.is_empty() {
            h3 { "Recordings without a session's log" }
            p { "Nothing states whether these trials were accepted." }
            ul { @for recording in unlogged_recordings { li { a href={ "#" (recording.anchor()) } { (recording.name()) } } } }
        }
    }
}

fn session_section(
    (folder, session): (&Path, &LoggedSession),
    content: &ReportContent<'_>,
    recordings: &[RecordingEntry<'_>],
) -> Markup {
    let is_in_folder = |recording: &&RecordingEntry<'_>| {
        content.sessions.folder_of(recording.path) == Some(folder)
    };
    // As in the recordings: if there are two studies, with the study's name.
    let mut session_recordings = recordings.iter().filter(is_in_folder);
    let participant = session_recordings.find_map(RecordingEntry::participant);
    let title = match &session.start {
        Some(start) => format!(
            "{}, session {}",
            participant.unwrap_or(&start.participant),
            start.session
        ),
        None => "Session without a start in its log".to_owned(),
    };
    let recording_of = |attempt: &Attempt| {
        let mut candidates = recordings.iter().filter(is_in_folder);
        candidates.find(|recording| {
            recording
                .attempt
                .is_some_and(|recorded_attempt| recorded_attempt.label == attempt.label)
        })
    };
    // Without the date, by which anyone who knows when a participant came could identify the person.
    let details = session.start.as_ref();
    let details = details.map(|start| format!("Protocol {}, seed {}", start.protocol, start.seed));
    html! {
        h3 { (title) }
        p.note {
            @if let Some(details) = &details { (details) "; " }
            @if session.n_resumptions > 0 { "resumed " (count_text(session.n_resumptions, "time", "times")) "; " }
            (session_end(&session.end)) "."
        }
        div.wide { table {
            thead { tr {
                th { "Attempt" } th { "Condition" } th.n { "Start (s)" } th { "Verdict" } th { "Reasons" }
                th { "Analysed" }
            } }
            tbody { @for attempt in &session.attempts {
                @let (verdict, reasons) = attempt.verdict();
                tr {
                    th scope="row" { (attempt.label) }
                    td { (attempt.condition) }
                    td.n { (SECONDS.value(attempt.start_s)) }
                    td { (verdict) }
                    td {
                        (reasons.join("; "))
                        @if attempt.outcome.is_none() { (UNSETTLED) }
                    }
                    td { @match recording_of(attempt) {
                        Some(recording) => a href={ "#" (recording.anchor()) } {
                            (count_text(recording.result.instances.len(), "instance", "instances"))
                        },
                        None => (if attempt.is_practice() { "no: practice" } else { "no" }),
                    } }
                }
            } }
        } }
    }
}

fn session_end(end: &SessionEnd) -> String {
    match end {
        SessionEnd::NotBegun | SessionEnd::Unfinished => "its log has no end".to_owned(),
        SessionEnd::Stopped { status, reason } => {
            let ending = match status {
                ExitStatus::Success => "completed",
                ExitStatus::Abort => "aborted by the operator",
                ExitStatus::Fail => "aborted by a fault",
            };
            reason
                .as_ref()
                .map_or_else(|| ending.to_owned(), |reason| format!("{ending}: {reason}"))
        }
    }
}
