//! Finds recordings: recording folders themselves, or the accepted trials of a study, a participant or a session.
//!
//! The session's log states which attempts were accepted, as read by [`study::sessions`]; for a session without a log, as made
//! elsewhere, the recordings alone decide.

use std::collections::{BTreeMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};

use recording::manifest::End;
use recording::study::{EVENTS_FILE, TrialBlock, TrialLabel};
use recording::{MANIFEST_FILE, reader};
use study::identity::{Duplicate, duplicates};
use study::listing::empty_cause;
use study::sessions::{Attempt, LoggedSession, SessionEnd, Standing};

use crate::exceptions::{Exceptions, UnusedException};
use crate::{Attempts, EmptySession, OmittedAttempt, SelectedAttempt};

/// Levels of folders below a study: participants, sessions, trials.
const DEPTH: usize = 3;
/// Reason of an attempt that the log does not have, or of which it has no verdict, and the remedy.
const NOT_IN_LOG: &str = "the session's log does not have it, or not its verdict; put the right log back, and compare it with \
                          `friction-bench verify`";

/// Reasons why a folder contains no recordings to analyse.
#[derive(Debug, thiserror::Error)]
pub enum FindError {
    /// The folder cannot be listed.
    #[error("cannot list {}: {}", path.display(), bounded_files::cause(reason))]
    List {
        /// Folder given.
        path: PathBuf,
        /// Reason of the failure.
        reason: io::Error,
    },
    /// Two folders contain the same attempt with different contents.
    #[error(
        "{duplicate}: only one of them can count; look which is right, and leave out the other with \
         --exclude {}",
        escaping::quoted(&duplicate.path)
    )]
    Ambiguous {
        /// Folder, and the one with the same attempt.
        duplicate: Duplicate,
    },
    /// A folder to be left out has no recording that was found.
    #[error(transparent)]
    Unused(#[from] UnusedException),
    /// The folders to be left out have all recordings of a folder.
    #[error("nothing is left of {}: all recordings to analyse are in the folders to be left out", path.display())]
    NothingLeft {
        /// Folder given.
        path: PathBuf,
    },
    /// The folder is neither a recording nor contains any.
    #[error(
        "{} is neither a recording (it has no {MANIFEST_FILE}) nor a study with accepted trials that can be \
         analysed{}{}{cause}",
        path.display(),
        if *.practice { "" } else { "; practice trials are left out unless --practice is given" },
        omissions.first().map(|attempt| format!("; left out: {attempt}")).unwrap_or_default()
    )]
    None {
        /// Folder given.
        path: PathBuf,
        /// Whether practice trials were looked for.
        practice: bool,
        /// Attempts that were found but left out.
        omissions: Vec<OmittedAttempt>,
        /// Likely cause and remedy, after a semicolon; empty if none is known.
        cause: &'static str,
    },
}

/// Trials to analyse in addition to the accepted ones of the experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrialFilter {
    /// Practice trials.
    pub practice: bool,
    /// Last completed attempt at each trial that was not accepted.
    pub rejected: bool,
}

/// Returns the recordings in `folders`, in order, and the attempts that are left out. A folder with a
/// `recording.toml` is a recording. For a study, the accepted trials are taken, by the logs of its sessions; for a session
/// without a log, the last completed attempt at each trial. A folder that is named twice counts once, and so does a recording
/// of which the folders contain copies.
///
/// # Errors
/// A folder cannot be listed or contains no recording, or two contain the same attempt with different contents.
pub fn attempts(folders: &[PathBuf], filter: TrialFilter) -> Result<Attempts, FindError> {
    attempts_except(folders, filter, &[])
}

/// Returns the recordings found by [`attempts`] outside the folders of `exceptions`.
///
/// # Errors
/// Same as [`attempts`], and a folder of `exceptions` has none of the recordings, or all of them.
pub fn attempts_except(
    folders: &[PathBuf],
    filter: TrialFilter,
    exceptions: &[PathBuf],
) -> Result<Attempts, FindError> {
    let mut attempts = Attempts::default();
    let mut known_folders = HashSet::new();
    let mut exceptions = Exceptions::new(exceptions);
    for path in folders {
        let mut search = Search {
            filter,
            attempts: Attempts::default(),
        };
        if path.join(MANIFEST_FILE).exists() {
            search.take(path.clone(), standing(path));
        } else {
            search.descend(path, DEPTH)?;
        }
        let mut folder_attempts = search.attempts;
        let is_found = !folder_attempts.selection.is_empty();
        exceptions.remove_from(path, &mut folder_attempts);
        if folder_attempts.selection.is_empty() && is_found {
            return Err(FindError::NothingLeft { path: path.clone() });
        }
        if folder_attempts.selection.is_empty() {
            return Err(FindError::None {
                path: path.clone(),
                practice: filter.practice,
                cause: empty_cause(path),
                omissions: folder_attempts.omissions,
            });
        }
        attempts.extend(folder_attempts, &mut known_folders);
    }
    exceptions.require_all_used()?;
    leave_out_duplicates(&mut attempts)?;
    Ok(attempts)
}

/// Leaves out the copies of other recordings.
fn leave_out_duplicates(attempts: &mut Attempts) -> Result<(), FindError> {
    let selection = attempts.selection.iter().map(|attempt| &attempt.path);
    let omissions = attempts.omissions.iter().map(|attempt| &attempt.path);
    let folders: Vec<PathBuf> = selection.chain(omissions).cloned().collect();
    for duplicate in duplicates(folders.iter().map(PathBuf::as_path)) {
        let is_selected = |path: &Path| {
            attempts
                .selection
                .iter()
                .any(|attempt| attempt.path == path)
        };
        if duplicate.is_copy {
            attempts.leave_out_copy(duplicate);
        } else if is_selected(&duplicate.path) {
            return Err(FindError::Ambiguous { duplicate });
        }
    }
    Ok(())
}

/// Returns the recordings found by [`attempts`], without those that are left out.
///
/// # Errors
/// Same as [`attempts`].
pub fn recordings(folders: &[PathBuf], practice: bool) -> Result<Vec<PathBuf>, FindError> {
    let filter = TrialFilter {
        practice,
        rejected: false,
    };
    attempts(folders, filter).map(|attempts| attempts.recordings())
}

/// Returns the outcome of the attempt of a named recording, by the log in its folder.
fn standing(recording: &Path) -> Option<Standing> {
    let folder = recording.canonicalize().ok()?;
    let label: TrialLabel = folder.file_name()?.to_str()?.parse().ok()?;
    let session = study::sessions::read(folder.parent()?).ok()?;
    let attempt = session.attempt(label);
    Some(attempt.map_or(Standing::Unknown, |attempt| attempt.standing()))
}

struct Search {
    filter: TrialFilter,
    attempts: Attempts,
}

impl Search {
    fn descend(&mut self, folder: &Path, depth: usize) -> Result<(), FindError> {
        let mut folders = list(folder)?;
        folders.sort_unstable();
        let mut labels = BTreeMap::new();
        for path in folders {
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            let label = name.and_then(|name| name.parse::<TrialLabel>().ok());
            match label {
                Some(label) => drop(labels.insert(label, path)),
                None if path.join(MANIFEST_FILE).exists() => self.take(path, None),
                None if depth > 1 => self.descend(&path, depth - 1)?,
                None => {}
            }
        }
        let log = folder.join(EVENTS_FILE);
        if !log.exists() {
            // A session that was made elsewhere has no log.
            if labels.values().any(|path| is_of_bench(path)) {
                let reason = "the log is missing, and with it which attempts were rejected; copy it from the bench";
                self.attempts.unread_logs.push((log, reason.to_owned()));
            }
            self.select_from_recordings(&labels);
            return Ok(());
        }
        match study::sessions::read(folder) {
            Ok(session) => self.select_from_log(folder, &session, &labels),
            Err(reason) => {
                self.attempts.unread_logs.push((log, reason));
                self.select_from_recordings(&labels);
            }
        }
        Ok(())
    }

    fn is_included(&self, label: TrialLabel) -> bool {
        label.block == TrialBlock::Main || self.filter.practice
    }

    /// Takes the last completed attempt at each trial, because the accepted ones are unknown.
    fn select_from_recordings(&mut self, labels: &BTreeMap<TrialLabel, PathBuf>) {
        let mut last_attempts = BTreeMap::new();
        for (label, path) in labels {
            if self.is_included(*label) && is_countable(path) {
                last_attempts.insert((label.block, label.number), path.clone());
            }
        }
        for path in last_attempts.into_values() {
            self.take(path, None);
        }
    }

    /// Takes the accepted attempts, and lists all others as left out.
    fn select_from_log(
        &mut self,
        folder: &Path,
        session: &LoggedSession,
        labels: &BTreeMap<TrialLabel, PathBuf>,
    ) {
        if session
            .accepted()
            .iter()
            .all(|attempt| attempt.is_practice())
        {
            self.attempts.empty_sessions.push(EmptySession {
                path: folder.to_owned(),
                because: course(session),
            });
        }
        let accepted_labels = session.accepted().into_iter().map(|attempt| attempt.label);
        let accepted_labels: Vec<TrialLabel> = accepted_labels
            .filter(|label| self.is_included(*label))
            .collect();
        let mut selection = BTreeMap::new();
        for label in &accepted_labels {
            let path = folder.join(label.to_string());
            let reason = match end(&path) {
                _ if !path.is_dir() => "its recording is not there",
                Some(Some(End::Completed)) | None => {
                    selection.insert((label.block, label.number), (path, Standing::Accepted));
                    continue;
                }
                Some(Some(End::Interrupted)) => "its recording was broken off",
                Some(None) => "its recording has no end",
            };
            self.leave_out(path, Standing::Accepted, reason);
        }
        let trial_key = |label: &TrialLabel| (label.block, label.number);
        let mut replacements = BTreeMap::new();
        for (label, path) in labels {
            if accepted_labels.contains(label) || !self.is_included(*label) {
                continue;
            }
            let attempt = session.attempt(*label);
            let standing = attempt.map_or(Standing::Unknown, Attempt::standing);
            let is_candidate = !accepted_labels
                .iter()
                .any(|accepted| trial_key(accepted) == trial_key(label))
                && is_countable(path);
            let is_unlogged = attempt.is_none_or(|attempt| session.lacks_verdict(attempt));
            if is_candidate && self.filter.rejected {
                let earlier_attempt =
                    replacements.insert(trial_key(label), (path.clone(), standing));
                if let Some((path, standing)) = earlier_attempt {
                    self.leave_out(path, standing, "a later attempt at its trial is analysed");
                }
            } else if is_candidate && is_unlogged {
                // It may have been accepted.
                self.attempts.omissions.push(OmittedAttempt {
                    path: path.clone(),
                    standing: None,
                    because: NOT_IN_LOG.to_owned(),
                });
            } else {
                let reason = match standing {
                    Standing::Accepted => "a later attempt at its trial was accepted too",
                    Standing::Repeated => "it was to be repeated",
                    Standing::GivenUp => "its trial was given up",
                    Standing::Interrupted => "it was interrupted",
                    Standing::Unknown => "it is not in the log",
                };
                self.leave_out(path.clone(), standing, reason);
            }
        }
        selection.extend(replacements);
        for (path, standing) in selection.into_values() {
            self.take(path, Some(standing));
        }
    }

    fn take(&mut self, path: PathBuf, standing: Option<Standing>) {
        self.attempts
            .selection
            .push(SelectedAttempt { path, standing });
    }

    fn leave_out(&mut self, path: PathBuf, standing: Standing, reason: &'static str) {
        self.attempts.omissions.push(OmittedAttempt {
            path,
            standing: Some(standing),
            because: reason.to_owned(),
        });
    }
}

/// Returns the course of a session without an accepted trial, in words.
fn course(session: &LoggedSession) -> String {
    let attempts = session.attempts.iter();
    let n_practice = attempts.filter(|attempt| attempt.is_practice()).count();
    let n_others = session.attempts.len() - n_practice;
    let attempts = match (n_practice, n_others) {
        (0, 0) => "no attempt was begun".to_owned(),
        (n, 0) => format!("attempts at practice trials only ({n})"),
        (_, n) => format!("attempts at trials: {n}"),
    };
    let end = match &session.end {
        SessionEnd::Stopped { reason: None, .. } => "the session was completed".to_owned(),
        SessionEnd::Stopped {
            reason: Some(reason),
            ..
        } => format!("the session was ended: {reason}"),
        SessionEnd::Unfinished | SessionEnd::NotBegun => {
            "its log has no end; `run --resume` continues it".to_owned()
        }
    };
    format!("{attempts}; {end}")
}

/// Returns whether a bench recorded the trial in `folder`.
fn is_of_bench(folder: &Path) -> bool {
    reader::read_manifest(folder).is_ok_and(|manifest| manifest.hardware.is_some())
}

/// Returns whether the trial in `folder` completed. An unreadable one counts, so that it is reported instead of
/// ignored.
fn is_countable(folder: &Path) -> bool {
    matches!(end(folder), None | Some(Some(End::Completed)))
}

/// Returns how the recording in `folder` ended; `None` if it cannot be read or does not belong to a trial.
fn end(folder: &Path) -> Option<Option<End>> {
    let trial = reader::read_manifest(folder).ok()?.trial?;
    Some(trial.end)
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, FindError> {
    let error = |reason| FindError::List {
        path: folder.to_owned(),
        reason,
    };
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(error)? {
        let path = entry.map_err(error)?.path();
        if path.is_dir() {
            folders.push(path);
        }
    }
    Ok(folders)
}

#[cfg(test)]
mod tests {
    use super::*;
    use analysis::Analysis;
    use recording::manifest::MINIMAL;
    use std::fs;

    /// Makes a session of these attempts: number, attempt, outcome in the log, and end of the recording, if any.
    fn session(attempts: &[(u32, u32, &str, &str)]) -> tempfile::TempDir {
        let temp_dir = tempfile::tempdir().unwrap();
        let folder = temp_dir.path().join("study/sub-01/ses-01");
        fs::create_dir_all(&folder).unwrap();
        let event = |data: String| {
            format!(
                r#"{{"document":"event","stream":"session","seq_num":1,"time":"","audio_s":1.0,"data":{data}}}"#
            )
        };
        let mut log = String::new();
        for (number, attempt, outcome, end) in attempts {
            let key = format!(
                r#"{{"number":{number},"attempt":{attempt},"practice":false,"condition":"c"}}"#
            );
            log += &event(format!(r#"{{"event":"trial_began","key":{key}}}"#));
            log += "\n";
            if !outcome.is_empty() {
                log += &event(format!(
                    r#"{{"event":"trial_settled","record":{{"key":{key},"outcome":{outcome},"analysis":null}}}}"#
                ));
                log += "\n";
            }
            if end.is_empty() {
                continue;
            }
            let recording = folder.join(format!("trial-{number:03}_attempt-{attempt}"));
            fs::create_dir(&recording).unwrap();
            let trial = format!(
                "trial = {{ number = {number}, attempt = {attempt}, practice = false, condition = \"c\", protocol = \"p\", \
                 seed = 1, end = \"{end}\" }}\n"
            );
            fs::write(recording.join(MANIFEST_FILE), MINIMAL.to_owned() + &trial).unwrap();
        }
        fs::write(folder.join(EVENTS_FILE), log).unwrap();
        temp_dir
    }

    const ACCEPTED: &str = r#"{"outcome":"accepted"}"#;
    const REDO: &str = r#"{"outcome":"redo","reasons":[]}"#;
    const GIVEN_UP: &str = r#"{"outcome":"given_up","reasons":[]}"#;

    fn attempt_names(temp_dir: &Path, rejected: bool) -> (Vec<String>, Vec<String>) {
        let filter = TrialFilter {
            practice: false,
            rejected,
        };
        let attempts = attempts(&[temp_dir.join("study")], filter).unwrap();
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let selection = attempts.selection.iter().map(|attempt| name(&attempt.path));
        let omissions = attempts.omissions.iter();
        let omissions =
            omissions.map(|attempt| format!("{}: {}", name(&attempt.path), attempt.because));
        (selection.collect(), omissions.collect())
    }

    /// Regression test: an abandoned trial and an interrupted repetition were analysed as data: n = 3 of 1 accepted.
    ///
    /// Fault 52.
    #[test]
    fn attempts_are_taken_by_their_standing_in_the_log() {
        let temp_dir = session(&[
            (1, 1, REDO, "completed"),
            (1, 2, ACCEPTED, "completed"),
            (2, 1, GIVEN_UP, "completed"),
            (3, 1, REDO, "completed"),
            (3, 2, "", "completed"),
        ]);
        let (selection, omissions) = attempt_names(temp_dir.path(), false);
        assert_eq!(selection, ["trial-001_attempt-2"]);
        assert_eq!(
            omissions,
            [
                "trial-001_attempt-1: it was to be repeated",
                "trial-002_attempt-1: its trial was given up",
                "trial-003_attempt-1: it was to be repeated",
                "trial-003_attempt-2: it was interrupted",
            ]
        );
        // Each trial still counts once.
        let (selection, omissions) = attempt_names(temp_dir.path(), true);
        assert_eq!(
            selection,
            [
                "trial-001_attempt-2",
                "trial-002_attempt-1",
                "trial-003_attempt-2"
            ]
        );
        assert_eq!(omissions.len(), 2);
    }

    /// Regression test: accepted trials without a complete recording were ignored silently.
    ///
    /// Fault 27.
    #[test]
    fn an_accepted_trial_that_cannot_be_analysed_is_named() {
        let temp_dir = session(&[
            (1, 1, ACCEPTED, "completed"),
            (2, 1, ACCEPTED, "interrupted"),
            (3, 1, ACCEPTED, ""),
        ]);
        let (selection, omissions) = attempt_names(temp_dir.path(), false);
        assert_eq!(selection, ["trial-001_attempt-1"]);
        assert_eq!(
            omissions,
            [
                "trial-002_attempt-1: its recording was broken off",
                "trial-003_attempt-1: its recording is not there",
            ]
        );
        let analysed = Analysis::default();
        let study = [temp_dir.path().join("study")];
        let account = attempts(&study, TrialFilter::default())
            .unwrap()
            .account(&analysed, &[]);
        assert_eq!(account.accepted, 3);
        assert_eq!(account.missed().count(), 2);
        assert_eq!(
            account.lines()[0],
            "accepted 3, analysed 0; left out: 2 missed"
        );
    }

    #[test]
    fn a_recording_that_the_log_lacks_is_named() {
        let temp_dir = session(&[
            (1, 1, ACCEPTED, "completed"),
            (2, 1, "", "completed"),
            (3, 1, ACCEPTED, "completed"),
            (4, 1, "", "completed"),
        ]);
        let folder = temp_dir.path().join("study/sub-01/ses-01");
        let named = |names: &[&str]| {
            for name in names {
                fs::create_dir(folder.join(name)).unwrap();
                let described = folder.join("trial-001_attempt-1").join(MANIFEST_FILE);
                fs::copy(described, folder.join(name).join(MANIFEST_FILE)).unwrap();
            }
            let study = [temp_dir.path().join("study")];
            let found = attempts(&study, TrialFilter::default()).unwrap();
            crate::missed_lines(found.omissions.iter().filter(|attempt| attempt.is_missed()))
        };
        // The lines of the second trial's verdict are lost; the program was killed in the fourth.
        let lines = named(&[]);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(
            lines[0].contains("trial-002_attempt-1: the session's log"),
            "{lines:?}"
        );
        // The first trial was accepted by the log.
        assert_eq!(named(&["trial-001_attempt-2"]).len(), 1);
        let lines = named(&["trial-005_attempt-1", "trial-006_attempt-1"]);
        assert_eq!(lines.len(), 3, "{lines:?}");
        let lines = named(&["trial-007_attempt-1", "trial-008_attempt-1"]);
        assert_eq!(lines.len(), 4, "{lines:?}");
        assert!(
            lines[3].contains("ses-01: 2 more of its recordings"),
            "{lines:?}"
        );
    }

    /// Fault 52.
    #[test]
    fn a_study_that_is_named_twice_counts_once_by_whichever_path() {
        let temp_dir = session(&[(1, 1, ACCEPTED, "completed"), (2, 1, GIVEN_UP, "completed")]);
        let study = temp_dir.path().join("study");
        let session = study.join("sub-01/../sub-01/ses-01");
        let mut folders = vec![
            study.clone(),
            session.clone(),
            session.join("trial-001_attempt-1"),
        ];
        #[cfg(unix)]
        {
            let link = temp_dir.path().join("link");
            std::os::unix::fs::symlink(&study, &link).unwrap();
            folders.push(link);
        }
        let study_attempts = attempts(&folders, TrialFilter::default()).unwrap();
        assert_eq!(
            (
                study_attempts.selection.len(),
                study_attempts.omissions.len()
            ),
            (1, 1)
        );
        // A folder that is named explicitly.
        let folders = [session.join("trial-002_attempt-1")];
        let folder_attempts = attempts(&folders, TrialFilter::default()).unwrap();
        assert_eq!(
            folder_attempts.selection[0].standing,
            Some(Standing::GivenUp)
        );
    }

    #[test]
    fn a_session_without_a_log_stands_for_the_last_completed_attempt_at_each_trial() {
        let temp_dir = session(&[
            (1, 1, ACCEPTED, "completed"),
            (1, 2, REDO, "completed"),
            (2, 1, ACCEPTED, "interrupted"),
        ]);
        let log = temp_dir
            .path()
            .join("study/sub-01/ses-01")
            .join(EVENTS_FILE);
        fs::write(&log, "no log\n{}\n").unwrap();
        let study = [temp_dir.path().join("study")];
        let damaged_log = attempts(&study, TrialFilter::default()).unwrap();
        assert_eq!(damaged_log.unread_logs.len(), 1);
        fs::remove_file(log).unwrap();
        let missing_log = attempts(&study, TrialFilter::default()).unwrap();
        assert!(missing_log.unread_logs.is_empty());
        // A bench writes a log of every session.
        let recording = study[0]
            .join("sub-01/ses-01/trial-001_attempt-1")
            .join(MANIFEST_FILE);
        let made_elsewhere = fs::read_to_string(&recording).unwrap();
        let hardware = "[hardware]\ninput_device = \"a\"\noutput_device = \"b\"\nsample_rate_hz = 192000\nsample_format = \"i32\"\n\
                        channel_names = []\nuncalibrated = true\n";
        fs::write(&recording, format!("{made_elsewhere}\n{hardware}")).unwrap();
        let of_bench = attempts(&study, TrialFilter::default()).unwrap();
        let [(_, reason)] = &of_bench.unread_logs[..] else {
            panic!("{of_bench:?}");
        };
        assert!(reason.contains("copy it from the bench"), "{reason}");
        fs::write(&recording, made_elsewhere).unwrap();
        for session_attempts in [damaged_log, missing_log] {
            assert_eq!(session_attempts.selection.len(), 1);
            assert!(
                session_attempts.selection[0]
                    .path
                    .ends_with("trial-001_attempt-2")
            );
            assert_eq!(session_attempts.selection[0].standing, None);
        }
    }
}
