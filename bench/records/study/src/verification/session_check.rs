//! Verification of a session: its log, its copies of files, and its recordings against the log.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use crate::identity::{Duplicate, are_equal, duplicates};
use crate::sessions::{Attempt, LoggedSession, SessionEnd, Standing, history_in};

use crate::verification::defect::{RecordingDefect, SessionDefect};
use crate::verification::findings::{Integrity, SessionFindings, TrialFindings};
use crate::verification::recording_check;
use crate::verification::resumption::is_changed;
use crate::verification::session_names::{folder_session, recordings, session_words};
use recording::disk::entries;
use recording::manifest::{End, Manifest};
use recording::reader::read_manifest;
use recording::study::event_log::{self, LogContent};
use recording::study::{EVENTS_FILE, TrialLabel, session_name};
use recording::{DiskError, MANIFEST_FILE};

/// Verifies the session in `folder`; calls `report_progress` after each recording.
///
/// # Errors
/// The folder cannot be listed.
pub fn session(
    folder: &Path,
    mut report_progress: impl FnMut(),
) -> Result<SessionFindings, DiskError> {
    let mut findings = SessionFindings {
        folder: folder.to_owned(),
        end: SessionEnd::NotBegun,
        planned: None,
        trials: Vec::new(),
        defects: Vec::new(),
        notes: Vec::new(),
    };
    let folder_labels: BTreeSet<TrialLabel> = recordings(folder)?.into_iter().collect();
    let path = folder.join(EVENTS_FILE);
    let content = match event_log::read(&path) {
        Ok(content) => content,
        Err(error) => {
            if path.exists() {
                let reason = error.to_string();
                findings.defects.push(SessionDefect::Unreadable { reason });
            } else if !folder_labels.is_empty() {
                findings.defects.push(SessionDefect::NoLog);
            }
            LogContent::default()
        }
    };
    let has_log = findings.defects.is_empty();
    for line in &content.torn_lines {
        let text = format!("{EVENTS_FILE}: line {line} was torn when the program was killed");
        findings.notes.push(text);
    }
    let history = history_in(folder, &content);
    check_copies(folder, &history, &mut findings);
    findings.defects.extend(changed_copies(folder, &content));
    let logged_labels = history.attempts.iter().map(|attempt| attempt.label);
    let labels: BTreeSet<TrialLabel> = logged_labels.chain(folder_labels.iter().copied()).collect();
    for label in labels {
        let attempt = history.attempt(label);
        let is_unsaved =
            attempt.is_some_and(|attempt| !attempt.is_saved && history.should_be_saved(attempt));
        let is_present = folder_labels.contains(&label);
        let trial = trial(folder, label, (attempt, is_unsaved), is_present, has_log);
        findings.trials.push(trial);
        if folder_labels.contains(&label) {
            report_progress();
        }
    }
    excuse_imports(folder, &folder_labels, &mut findings);
    report_foreign_folders(folder, &mut findings)?;
    findings.end = history.end;
    findings.planned = history.planned;
    findings
        .defects
        .extend(history.defects.into_iter().map(SessionDefect::from));
    Ok(findings)
}

/// Turns the missing log of a session that consists of imported recordings into a note.
fn excuse_imports(folder: &Path, labels: &BTreeSet<TrialLabel>, findings: &mut SessionFindings) {
    let is_imported = |label: &TrialLabel| {
        let manifest = read_manifest(&folder.join(label.to_string()));
        manifest.is_ok_and(|manifest| {
            manifest
                .origin
                .is_some_and(|origin| origin.imported.is_some())
        })
    };
    let is_excused = |defect: &SessionDefect| matches!(defect, SessionDefect::NoLog);
    if findings.defects.iter().any(is_excused) && labels.iter().all(is_imported) {
        findings.defects.retain(|defect| !is_excused(defect));
        let note = "its recordings were imported: no log states their sums, so only their files are checked";
        findings.notes.push(note.to_owned());
    }
}

/// Verifies the last attempt of a session; `None` if there was no attempt.
///
/// # Errors
/// The folder cannot be listed.
pub fn last_trial(
    folder: &Path,
    history: &LoggedSession,
) -> Result<Option<TrialFindings>, DiskError> {
    let folder_labels: BTreeSet<TrialLabel> = recordings(folder)?.into_iter().collect();
    let logged_labels = history.attempts.iter().map(|attempt| attempt.label);
    let last_label = logged_labels.chain(folder_labels.iter().copied()).max();
    Ok(last_label.map(|label| {
        let is_present = folder_labels.contains(&label);
        trial(
            folder,
            label,
            (history.attempt(label), false),
            is_present,
            true,
        )
    }))
}

/// Returns the session's copy of a file, which must be TOML.
fn copy(folder: &Path, file: &str) -> Result<String, SessionDefect> {
    let broken_copy = |reason| SessionDefect::BrokenCopy {
        file: file.to_owned(),
        reason,
    };
    let path = folder.join(file);
    let text =
        bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES).map_err(|error| {
            if error.kind() == io::ErrorKind::NotFound {
                SessionDefect::NoCopy {
                    file: file.to_owned(),
                }
            } else {
                broken_copy(format!("{file}: {}", bounded_files::cause(&error)))
            }
        })?;
    match strict_toml::parse::<toml::Table>(&text, file) {
        Ok(_) => Ok(text),
        Err(error) => Err(broken_copy(error.to_string())),
    }
}

/// Checks the session's copies of files, and its folder, against the last start.
fn check_copies(folder: &Path, history: &LoggedSession, findings: &mut SessionFindings) {
    if let Some(start) = &history.last_start {
        let protocol = format!("{}.toml", start.protocol);
        findings.defects.extend(copy(folder, &protocol).err());
        let mut copies = vec!["bench.toml"];
        copies.extend(start.calibration.is_some().then_some("calibration.toml"));
        for file in copies {
            findings.defects.extend(copy(folder, file).err());
        }
        findings
            .defects
            .extend(copied_session(folder, start.session));
        let log_session = session_words(start);
        let expected = folder_session(folder);
        if expected
            .as_ref()
            .is_some_and(|expected| *expected != log_session)
        {
            findings.defects.push(SessionDefect::OtherSession {
                found: log_session,
                expected: expected.unwrap_or_default(),
            });
        }
    }
}

/// Returns the defects of copies that are no longer as the log states them; the first part that had a copy wrote it.
fn changed_copies(folder: &Path, log: &LogContent) -> Vec<SessionDefect> {
    let mut written: BTreeMap<&String, &String> = BTreeMap::new();
    for (file, sum) in log.starts().flat_map(|start| &start.copies) {
        written.entry(file).or_insert(sum);
    }
    let changed = written
        .into_iter()
        .filter(|(file, sum)| is_plain(file) && is_changed(&folder.join(file), sum));
    let changed = changed.map(|(file, _)| SessionDefect::ChangedCopy { file: file.clone() });
    changed.collect()
}

/// Returns whether a name of a log stays in its folder.
fn is_plain(file: &str) -> bool {
    Path::new(file).file_name() == Some(file.as_ref())
}

/// Returns the defect of a folder beside that of its `session`, as synchronisation programs and backups leave it.
fn copied_session(folder: &Path, session: u32) -> Option<SessionDefect> {
    let folder = folder.canonicalize().ok()?;
    let name = folder.file_name()?.to_string_lossy().into_owned();
    let original = session_name(session);
    let original_log = folder.parent()?.join(&original).join(EVENTS_FILE);
    if name == original || !original_log.exists() {
        return None;
    }
    let is_equal = are_equal(&folder.join(EVENTS_FILE), &original_log).unwrap_or(false);
    Some(SessionDefect::CopiedSession {
        name,
        original,
        is_equal,
    })
}

fn trial(
    session: &Path,
    label: TrialLabel,
    (attempt, is_unsaved): (Option<&Attempt>, bool),
    is_present: bool,
    has_log: bool,
) -> TrialFindings {
    let mut findings = TrialFindings {
        label,
        standing: attempt.map_or(Standing::Unknown, Attempt::standing),
        integrity: Integrity::NotRecorded,
        defects: Vec::new(),
        notes: Vec::new(),
    };
    let is_saved = attempt.is_some_and(|attempt| attempt.is_saved);
    let is_judged = matches!(
        findings.standing,
        Standing::Accepted | Standing::Repeated | Standing::GivenUp
    );
    if !is_present {
        if is_saved || is_judged {
            findings.integrity = Integrity::Missing;
            findings.defects.push(RecordingDefect::NoFolder);
        }
        return findings;
    }
    let folder = session.join(label.to_string());
    let is_begun_only = !is_saved && !is_judged && !folder.join(MANIFEST_FILE).exists();
    if is_begun_only {
        let text = "the program was killed before it had written the description";
        findings.notes.push(text.to_owned());
        return findings;
    }
    let accepted_attempt = attempt.filter(|_| findings.standing == Standing::Accepted);
    let sums = attempt.and_then(|attempt| attempt.sums.as_ref());
    let check = recording_check::check(&folder, sums);
    findings.defects = check.defects;
    findings.notes = check.notes;
    if let Some(manifest) = &check.manifest {
        findings
            .defects
            .extend(label_defect(session, label, manifest));
        let end = manifest.trial.as_ref().and_then(|trial| trial.end);
        if end.is_none() && manifest.trial.is_some() && (is_saved || is_judged) {
            findings.defects.push(RecordingDefect::NoEnd);
        }
        let is_interrupted = attempt.is_some_and(|attempt| attempt.is_interrupted);
        if is_interrupted && end == Some(End::Completed) {
            findings.defects.push(RecordingDefect::OtherEnd);
        }
        if let Some(attempt) = accepted_attempt {
            findings
                .defects
                .extend(acceptance_defect(attempt, manifest));
            findings.defects.extend(check.not_covered);
        }
        if attempt.is_none() && has_log {
            if end.is_some() {
                findings.defects.push(RecordingDefect::NotInLog);
            } else {
                findings.standing = Standing::Interrupted;
                let text = "the program was killed before it reached the log";
                findings.notes.push(text.to_owned());
            }
        }
        if accepted_attempt.is_some() && is_unsaved {
            findings.defects.push(RecordingDefect::AcceptedUnsaved);
        } else if is_judged && !is_saved && end == Some(End::Completed) {
            let text = "the log does not call it saved: the program ended too early";
            findings.notes.push(text.to_owned());
        }
    }
    findings.integrity = match (findings.defects.is_empty(), sums) {
        (false, _) => Integrity::Damaged,
        (true, Some(_)) => Integrity::Intact,
        (true, None) => Integrity::NoSum,
    };
    findings
}

/// Returns the defect of an accepted trial's description, if it has one.
fn acceptance_defect(attempt: &Attempt, manifest: &Manifest) -> Option<RecordingDefect> {
    let end = manifest.trial.as_ref()?.end;
    let (marked, recorded) = (attempt.intervals.len(), manifest.intervals.len());
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
fn label_defect(session: &Path, label: TrialLabel, manifest: &Manifest) -> Option<RecordingDefect> {
    let trial = manifest.trial.as_ref()?;
    let description_label = trial.label();
    let description_session = manifest
        .participant
        .as_ref()
        .map(|participant| format!("{}, session {}", participant.id, participant.session));
    let folder_session = folder_session(session);
    let differs = description_session.is_some()
        && folder_session.is_some()
        && description_session != folder_session;
    (description_label != label || differs).then(|| RecordingDefect::OtherTrial {
        found: format!(
            "{description_label} of {}",
            description_session.unwrap_or_default()
        ),
        expected: format!("{label} of {}", folder_session.unwrap_or_default()),
    })
}

/// Returns the trial of the session in `folder` that the recording in `path` duplicates.
fn duplicate_in(folder: &Path, path: &Path) -> Option<Duplicate> {
    let label = read_manifest(path).ok()?.trial?.label();
    let trial = folder.join(label.to_string());
    duplicates([&*trial, path])
        .into_iter()
        .find(|recording| recording.path == path)
}

/// Reports folders that are not trials.
fn report_foreign_folders(folder: &Path, findings: &mut SessionFindings) -> Result<(), DiskError> {
    for name in entries(folder)? {
        let path = folder.join(&name);
        if !path.is_dir() || name.parse::<TrialLabel>().is_ok() {
            continue;
        }
        if path.join(MANIFEST_FILE).exists() {
            let duplicate = duplicate_in(folder, &path);
            let defect = SessionDefect::ForeignRecording { name, duplicate };
            findings.defects.push(defect);
        } else {
            findings
                .notes
                .push(format!("{name} is not part of the session"));
        }
    }
    Ok(())
}
