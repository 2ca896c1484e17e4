//! Findings of a verification as text and as JSON.

use std::fmt::{Display, Write};

use escaping::{escaped, escaped_line};
use recording::study::TrialBlock;
use recording::study::event_log::ExitStatus;
use serde_json::{Value, json};

use crate::sessions::{SessionEnd, Standing};

use crate::verification::findings::{Integrity, SessionFindings, StudyFindings, TrialFindings};

/// Version of the JSON.
const FORMAT: u32 = 1;

/// Returns the findings as text: a line for each session and each attempt, followed by its defects.
pub fn to_text(findings: &StudyFindings) -> String {
    let mut text = String::new();
    for session in &findings.sessions {
        let _ = writeln!(
            text,
            "{}: {}",
            escaped_line(&session.folder.display().to_string()),
            session_words(session)
        );
        for trial in &session.trials {
            let _ = writeln!(
                text,
                "  {:<26} {:<21} {}",
                trial.label.to_string(),
                standing(trial),
                trial.integrity
            );
            remarks(&mut text, "      ", &trial.defects, &trial.notes);
        }
        remarks(&mut text, "  ", &session.defects, &session.notes);
    }
    remarks(&mut text, "", &findings.defects, &findings.notes);
    let _ = writeln!(text, "{}", conclusion(findings));
    // Names of files are of anybody.
    escaped(&text).into_owned()
}

fn remarks(text: &mut String, indent: &str, defects: &[impl Display], notes: &[String]) {
    for defect in defects {
        let _ = writeln!(text, "{indent}WRONG: {defect}");
    }
    for note in notes {
        let _ = writeln!(text, "{indent}note: {note}");
    }
}

/// Returns a description of one attempt: its standing, its integrity and its defects.
#[must_use]
pub fn trial_words(trial: &TrialFindings) -> String {
    let mut words = format!("{}: {}, {}", trial.label, standing(trial), trial.integrity);
    for defect in &trial.defects {
        let _ = write!(words, "; {defect}");
    }
    words
}

fn standing(trial: &TrialFindings) -> String {
    match (trial.label.block, trial.standing) {
        (TrialBlock::Practice, Standing::Accepted) => "practice".to_owned(),
        (TrialBlock::Practice, standing) => format!("practice, {standing}"),
        (TrialBlock::Main, standing) => standing.to_string(),
    }
}

fn session_words(session: &SessionFindings) -> String {
    let trials = session.planned.map_or_else(
        || format!("{} trials accepted", session.accepted()),
        |planned| format!("{} of {planned} trials accepted", session.accepted()),
    );
    let end = match &session.end {
        SessionEnd::Stopped {
            status: ExitStatus::Success,
            ..
        } => "complete".to_owned(),
        SessionEnd::Stopped { reason, .. } => {
            let reason = reason.as_deref().unwrap_or("no reason given");
            format!("ended early ({reason})")
        }
        SessionEnd::Unfinished => "unfinished: the program was killed, or still runs".to_owned(),
        SessionEnd::NotBegun if !session.trials.is_empty() => {
            return "no log states its course".to_owned();
        }
        SessionEnd::NotBegun => return "nothing was begun".to_owned(),
    };
    format!("{end}, {trials}")
}

/// Counts the attempts by integrity.
fn counts(findings: &StudyFindings) -> [(Integrity, usize); 5] {
    [
        Integrity::Intact,
        Integrity::NoSum,
        Integrity::Damaged,
        Integrity::Missing,
        Integrity::NotRecorded,
    ]
    .map(|integrity| {
        let sessions = findings.sessions.iter();
        let trials = sessions.flat_map(|session| &session.trials);
        let count = trials.filter(|trial| trial.integrity == integrity).count();
        (integrity, count)
    })
}

fn conclusion(findings: &StudyFindings) -> String {
    let count_text: Vec<String> = counts(findings)
        .into_iter()
        .filter(|(_, count)| *count > 0)
        .map(|(integrity, count)| format!("{integrity}: {count}"))
        .collect();
    let count_text = if count_text.is_empty() {
        "no recordings".to_owned()
    } else {
        count_text.join(", ")
    };
    if findings.is_whole() {
        format!("nothing is damaged or missing ({count_text})")
    } else {
        format!("NOT WHOLE: see the lines that begin with WRONG ({count_text})")
    }
}

fn texts(items: &[impl Display]) -> Vec<String> {
    items.iter().map(ToString::to_string).collect()
}

/// Returns the findings as JSON.
///
/// # Errors
/// Never fails for findings.
pub fn to_json(findings: &StudyFindings) -> serde_json::Result<String> {
    let sessions: Vec<Value> = findings.sessions.iter().map(session_json).collect();
    let report = json!({
        "format": FORMAT,
        "whole": findings.is_whole(),
        "sessions": sessions,
        "wrong": texts(&findings.defects),
        "notes": findings.notes,
    });
    Ok(serde_json::to_string_pretty(&report)? + "\n")
}

fn session_json(session: &SessionFindings) -> Value {
    let trials = session.trials.iter().map(|trial| {
        json!({
            "name": trial.label.to_string(),
            "practice": trial.label.block == TrialBlock::Practice,
            "standing": trial.standing.to_string(),
            "integrity": match trial.integrity {
                Integrity::Intact => "intact",
                Integrity::NoSum => "no_sum",
                Integrity::Damaged => "damaged",
                Integrity::Missing => "missing",
                Integrity::NotRecorded => "not_recorded",
            },
            "wrong": texts(&trial.defects),
            "notes": trial.notes,
        })
    });
    let (end, reason) = match &session.end {
        SessionEnd::Stopped { status, reason } => (json!(status), reason.clone()),
        SessionEnd::Unfinished => (json!("unfinished"), None),
        SessionEnd::NotBegun => (json!("not_begun"), None),
    };
    json!({
        "path": session.folder.display().to_string(),
        "end": end,
        "reason": reason,
        "accepted": session.accepted(),
        "planned": session.planned,
        "trials": trials.collect::<Vec<_>>(),
        "wrong": texts(&session.defects),
        "notes": session.notes,
    })
}
