//! Verification of a session: its log, its copies of files, and its recordings against the log.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;

use ::sessions::{Attempt, Standing, practice};

use crate::defect::{RecordingDefect, SessionDefect};
use crate::findings::{Integrity, SessionEnd, SessionFindings, TrialFindings};
use crate::history::SessionHistory;
use crate::recording_check;
use recording::disk::entries;
use recording::manifest::{End, Manifest};
use recording::study::event_log::{self, LogContent};
use recording::study::{EVENTS_FILE, TrialBlock, TrialLabel};
use recording::{DiskError, MANIFEST_FILE};

/// Returns the recordings that have a folder in the session.
///
/// # Errors
/// The folder cannot be listed.
pub fn recordings(session: &Path) -> Result<Vec<TrialLabel>, DiskError> {
    let mut labels: Vec<TrialLabel> = entries(session)?
        .iter()
        .filter_map(|name| name.parse().ok())
        .collect();
    labels.sort_unstable();
    Ok(labels)
}

/// Verifies the session in `folder`; calls `done` after each recording.
///
/// # Errors
/// The folder cannot be listed.
pub fn session(folder: &Path, mut done: impl FnMut()) -> Result<SessionFindings, DiskError> {
    let mut found = SessionFindings {
        folder: folder.to_owned(),
        end: SessionEnd::NotBegun,
        planned: None,
        trials: Vec::new(),
        defects: Vec::new(),
        notes: Vec::new(),
    };
    let present: BTreeSet<TrialLabel> = recordings(folder)?.into_iter().collect();
    let path = folder.join(EVENTS_FILE);
    let content = match event_log::read(&path) {
        Ok(content) => content,
        Err(error) => {
            if path.exists() {
                let reason = error.to_string();
                found.defects.push(SessionDefect::Unreadable { reason });
            } else if !present.is_empty() {
                found.defects.push(SessionDefect::NoLog);
            }
            LogContent::default()
        }
    };
    let has_log = found.defects.is_empty();
    for line in &content.torn_lines {
        let text = format!("{EVENTS_FILE}: line {line} was torn when the program was killed");
        found.notes.push(text);
    }
    let history = history(folder, &content, &mut found);
    let labels: BTreeSet<TrialLabel> = history.attempts.keys().chain(&present).copied().collect();
    for label in labels {
        let attempt = history.attempts.get(&label);
        let unsaved = attempt.is_some_and(|of| !of.saved && history.should_be_saved(of));
        let here = present.contains(&label);
        let trial = trial(folder, label, (attempt, unsaved), here, has_log);
        found.trials.push(trial);
        if present.contains(&label) {
            done();
        }
    }
    strangers(folder, &mut found)?;
    found.end = history.end;
    found.planned = history.planned;
    found.defects.extend(history.defects);
    Ok(found)
}

/// Verifies the last attempt of a session with the log `content`; `None` if there was no attempt.
///
/// # Errors
/// The folder cannot be listed.
pub fn last_trial(folder: &Path, content: &LogContent) -> Result<Option<TrialFindings>, DiskError> {
    let present: BTreeSet<TrialLabel> = recordings(folder)?.into_iter().collect();
    let history = SessionHistory::of(content, practice(folder, content));
    let known = history.attempts.keys();
    Ok(known.chain(&present).max().map(|label| {
        let attempt = history.attempts.get(label);
        let here = present.contains(label);
        trial(folder, *label, (attempt, false), here, true)
    }))
}

/// Returns the defects in the order of a session's log.
#[must_use]
pub fn log_defects(folder: &Path, content: &LogContent) -> Vec<SessionDefect> {
    SessionHistory::of(content, practice(folder, content)).defects
}

/// Returns the session's copy of a file, which must be TOML.
fn copy(folder: &Path, file: &str) -> Result<String, SessionDefect> {
    let broken = |reason| SessionDefect::BrokenCopy {
        file: file.to_owned(),
        reason,
    };
    let text = fs::read_to_string(folder.join(file)).map_err(|error| {
        if error.kind() == io::ErrorKind::NotFound {
            SessionDefect::NoCopy {
                file: file.to_owned(),
            }
        } else {
            broken(error.to_string())
        }
    })?;
    match text.parse::<toml::Table>() {
        Ok(_) => Ok(text),
        Err(error) => Err(broken(error.message().to_owned())),
    }
}

fn history(folder: &Path, content: &LogContent, found: &mut SessionFindings) -> SessionHistory {
    let history = SessionHistory::of(content, practice(folder, content));
    if let Some(start) = &history.start {
        let protocol = format!("{}.toml", start.protocol);
        found.defects.extend(copy(folder, &protocol).err());
        let mut copies = vec!["bench.toml"];
        copies.extend(start.calibration.is_some().then_some("calibration.toml"));
        for file in copies {
            found.defects.extend(copy(folder, file).err());
        }
        let said = format!("{}, session {}", start.participant, start.session);
        let expected = names(folder);
        if expected.as_ref().is_some_and(|expected| *expected != said) {
            found.defects.push(SessionDefect::OtherSession {
                found: said,
                expected: expected.unwrap_or_default(),
            });
        }
    }
    history
}

/// Returns participant and session by the names of the folders, if these follow a study's scheme.
fn names(folder: &Path) -> Option<String> {
    let folder = folder.canonicalize().ok()?;
    let number: u32 = folder
        .file_name()?
        .to_str()?
        .strip_prefix("ses-")?
        .parse()
        .ok()?;
    let participant = folder.parent()?.file_name()?.to_str()?;
    Some(format!("{participant}, session {number}"))
}

fn trial(
    session: &Path,
    label: TrialLabel,
    (attempt, unsaved): (Option<&Attempt>, bool),
    present: bool,
    has_log: bool,
) -> TrialFindings {
    let mut found = TrialFindings {
        label,
        standing: attempt.map_or(Standing::Unknown, Attempt::standing),
        integrity: Integrity::NotRecorded,
        defects: Vec::new(),
        notes: Vec::new(),
    };
    let saved = attempt.is_some_and(|attempt| attempt.saved);
    let judged = matches!(
        found.standing,
        Standing::Accepted | Standing::Repeated | Standing::GivenUp
    );
    if !present {
        if saved || judged {
            found.integrity = Integrity::Missing;
            found.defects.push(RecordingDefect::NoFolder);
        }
        return found;
    }
    let folder = session.join(label.to_string());
    let begun_only = !saved && !judged && !folder.join(MANIFEST_FILE).exists();
    if begun_only {
        let text = "the program was killed before it had written the description";
        found.notes.push(text.to_owned());
        return found;
    }
    let accepted = attempt.filter(|_| found.standing == Standing::Accepted);
    let sums = attempt.and_then(|attempt| attempt.sums.as_ref());
    let check = recording_check::check(&folder, sums);
    found.defects = check.defects;
    found.notes = check.notes;
    if let Some(manifest) = &check.manifest {
        found.defects.extend(other_trial(session, label, manifest));
        let end = manifest.trial.as_ref().and_then(|trial| trial.end);
        if end.is_none() && manifest.trial.is_some() && (saved || judged) {
            found.defects.push(RecordingDefect::NoEnd);
        }
        let broken_off = attempt.is_some_and(|attempt| attempt.interrupted);
        if broken_off && end == Some(End::Completed) {
            found.defects.push(RecordingDefect::OtherEnd);
        }
        if let Some(attempt) = accepted {
            found.defects.extend(of_accepted(attempt, manifest));
            found.defects.extend(check.not_covered);
        }
        if attempt.is_none() && has_log {
            if end.is_some() {
                found.defects.push(RecordingDefect::NotInLog);
            } else {
                found.standing = Standing::Interrupted;
                let text = "the program was killed before the log told of it";
                found.notes.push(text.to_owned());
            }
        }
        if accepted.is_some() && unsaved {
            found.defects.push(RecordingDefect::AcceptedUnsaved);
        } else if judged && !saved && end == Some(End::Completed) {
            let text = "the log does not call it saved: the program ended too early";
            found.notes.push(text.to_owned());
        }
    }
    found.integrity = match (found.defects.is_empty(), sums) {
        (false, _) => Integrity::Damaged,
        (true, Some(_)) => Integrity::Intact,
        (true, None) => Integrity::NoSum,
    };
    found
}

/// Returns the defect of an accepted trial's description, if it has one.
fn of_accepted(attempt: &Attempt, manifest: &Manifest) -> Option<RecordingDefect> {
    let end = manifest.trial.as_ref()?.end;
    let (marked, recorded) = (attempt.marked.len(), manifest.intervals.len());
    if end == Some(End::Interrupted) {
        Some(RecordingDefect::AcceptedBrokenOff)
    } else if marked > 0 && marked != recorded && end == Some(End::Completed) {
        // Logs of early versions mark no intervals.
        Some(RecordingDefect::OtherIntervals { marked, recorded })
    } else {
        None
    }
}

/// Compares the description with the names of the folders.
fn other_trial(session: &Path, label: TrialLabel, manifest: &Manifest) -> Option<RecordingDefect> {
    let trial = manifest.trial.as_ref()?;
    let said = TrialLabel {
        block: if trial.practice {
            TrialBlock::Practice
        } else {
            TrialBlock::Main
        },
        number: trial.number,
        attempt: trial.attempt,
    };
    let whose = manifest
        .participant
        .as_ref()
        .map(|participant| format!("{}, session {}", participant.id, participant.session));
    let folders = names(session);
    let elsewhere = whose.is_some() && folders.is_some() && whose != folders;
    (said != label || elsewhere).then(|| RecordingDefect::OtherTrial {
        found: format!("{said} of {}", whose.unwrap_or_default()),
        expected: format!("{label} of {}", folders.unwrap_or_default()),
    })
}

/// Reports folders that are not trials.
fn strangers(folder: &Path, found: &mut SessionFindings) -> Result<(), DiskError> {
    for name in entries(folder)? {
        let path = folder.join(&name);
        if !path.is_dir() || name.parse::<TrialLabel>().is_ok() {
            continue;
        }
        if path.join(MANIFEST_FILE).exists() {
            found.defects.push(SessionDefect::ForeignRecording { name });
        } else {
            found
                .notes
                .push(format!("{name} is no part of the session"));
        }
    }
    Ok(())
}
