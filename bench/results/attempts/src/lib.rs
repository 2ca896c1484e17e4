//! Attempts at trials by their outcome: which are analysed, which are left out, and why.

mod exceptions;
pub mod find;

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use study::identity::Duplicate;
use study::sessions::Standing;

use analysis::Analysis;

pub use exceptions::UnusedException;

/// Number of attempts of a session, left out for one reason, that are named.
const NAMED_ALIKE: usize = 3;

/// Attempt with a recording that is analysed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SelectedAttempt {
    /// Folder of its recording.
    pub path: PathBuf,
    /// Outcome of the attempt; `None` without a log that records it.
    pub standing: Option<Standing>,
}

/// Attempt that is left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OmittedAttempt {
    /// Folder of its recording, which may be missing.
    pub path: PathBuf,
    /// Outcome of the attempt; `None` without a log that records it.
    pub standing: Option<Standing>,
    /// Reason for leaving it out.
    pub because: String,
}

impl OmittedAttempt {
    /// Returns whether this is an error: an accepted trial is always analysed, unless it was excluded on purpose.
    #[must_use]
    pub fn is_missed(&self) -> bool {
        matches!(self.standing, None | Some(Standing::Accepted))
    }
}

impl fmt::Display for OmittedAttempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(standing) = self.standing {
            write!(f, " ({standing})")?;
        }
        write!(f, ": {}", self.because)
    }
}

/// Session without an accepted trial.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct EmptySession {
    /// Folder of the session.
    pub path: PathBuf,
    /// Reason, such as how its log ends.
    pub because: String,
}

impl fmt::Display for EmptySession {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        write!(f, "{path}: no accepted trial, {}", self.because)
    }
}

/// Attempts found in the folders given for an analysis.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Attempts {
    /// Attempts that are analysed, in order.
    pub selection: Vec<SelectedAttempt>,
    /// Attempts that are left out.
    pub omissions: Vec<OmittedAttempt>,
    /// Sessions without an accepted trial.
    pub empty_sessions: Vec<EmptySession>,
    /// Logs that cannot be read, with the reason: the accepted attempts of their sessions are unknown.
    pub unread_logs: Vec<(PathBuf, String)>,
    /// Copies of other recordings, which are left out.
    pub copies: Vec<Duplicate>,
}

impl Attempts {
    /// Returns the recordings that are analysed.
    #[must_use]
    pub fn recordings(&self) -> Vec<PathBuf> {
        self.selection
            .iter()
            .map(|attempt| attempt.path.clone())
            .collect()
    }

    /// Leaves out a copy of another recording.
    pub(crate) fn leave_out_copy(&mut self, copy: Duplicate) {
        self.selection.retain(|attempt| attempt.path != copy.path);
        self.omissions.retain(|attempt| attempt.path != copy.path);
        self.omissions.push(OmittedAttempt {
            path: copy.path.clone(),
            standing: Some(Standing::Unknown),
            because: format!("it is a copy of {}", copy.original.display()),
        });
        self.copies.push(copy);
    }

    /// Adds further attempts, except those in `known_folders`.
    pub(crate) fn extend(&mut self, attempts: Self, known_folders: &mut HashSet<PathBuf>) {
        let selection = attempts.selection.into_iter();
        self.selection.extend(
            selection.filter(|attempt| known_folders.insert(canonical_path(&attempt.path))),
        );
        let omissions = attempts.omissions.into_iter();
        self.omissions.extend(
            omissions.filter(|attempt| known_folders.insert(canonical_path(&attempt.path))),
        );
        for session in attempts.empty_sessions {
            if !self.empty_sessions.contains(&session) {
                self.empty_sessions.push(session);
            }
        }
        for log in attempts.unread_logs {
            if !self.unread_logs.contains(&log) {
                self.unread_logs.push(log);
            }
        }
    }

    /// Returns the account of all attempts in an analysis; `excluded` are recordings left out on purpose.
    #[must_use]
    pub fn account(&self, analysed: &Analysis, excluded: &[PathBuf]) -> AttemptAccount {
        let is_accepted = |standing: Option<Standing>| standing == Some(Standing::Accepted);
        let mut account = AttemptAccount {
            accepted: self
                .selection
                .iter()
                .filter(|attempt| is_accepted(attempt.standing))
                .count()
                + (self
                    .omissions
                    .iter()
                    .filter(|attempt| is_accepted(attempt.standing)))
                .count(),
            analysed: 0,
            not_accepted: 0,
            excluded: excluded.len(),
            left_out: Vec::new(),
            empty_sessions: self.empty_sessions.clone(),
            unread_logs: self.unread_logs.iter().map(log_message).collect(),
        };
        let standings: BTreeMap<&Path, Option<Standing>> = self
            .selection
            .iter()
            .map(|attempt| (attempt.path.as_path(), attempt.standing))
            .collect();
        for recording in &analysed.recordings {
            let standing = standings.get(recording.path.as_path()).copied().flatten();
            match &recording.findings {
                Ok(_) => {
                    account.analysed += 1;
                    account.not_accepted +=
                        usize::from(standing.is_some() && !is_accepted(standing));
                }
                Err(error) => account.left_out.push(OmittedAttempt {
                    path: recording.path.clone(),
                    standing,
                    because: format!("it cannot be read: {error}"),
                }),
            }
        }
        let omissions = self.omissions.iter();
        let omissions = omissions.filter(|attempt| !excluded.contains(&attempt.path));
        account.left_out.extend(omissions.cloned());
        account
    }
}

/// Returns a line for each attempt; of many in a session that its log lacks, a line for the first ones and one for the others.
#[must_use]
pub fn missed_lines<'a>(missed: impl IntoIterator<Item = &'a OmittedAttempt>) -> Vec<String> {
    let missed: Vec<&OmittedAttempt> = missed.into_iter().collect();
    let are_alike = |a: &&OmittedAttempt, b: &&OmittedAttempt| {
        (a.path.parent(), a.standing, &a.because) == (b.path.parent(), None, &b.because)
    };
    let mut lines = Vec::new();
    for alike in missed.chunk_by(are_alike) {
        let named = alike.iter().take(NAMED_ALIKE).map(ToString::to_string);
        lines.extend(named);
        if let Some(OmittedAttempt { path, because, .. }) = alike.get(NAMED_ALIKE) {
            let folder = path.parent().unwrap_or(path).display();
            let count = alike.len() - NAMED_ALIKE;
            lines.push(format!(
                "{folder}: {count} more of its recordings: {because}"
            ));
        }
    }
    lines
}

fn log_message((path, reason): &(PathBuf, String)) -> String {
    format!(
        "{}: the accepted attempts are unknown, so the last completed one of each trial is analysed: {reason}",
        path.display()
    )
}

/// Returns a folder's canonical path, even if the folder does not exist.
pub(crate) fn canonical_path(path: &Path) -> PathBuf {
    let path_in_parent = || Some(path.parent()?.canonicalize().ok()?.join(path.file_name()?));
    let canonical_path = path.canonicalize().ok().or_else(path_in_parent);
    canonical_path.unwrap_or_else(|| path.to_owned())
}

/// Account of the attempts of an analysis, as in `attempts` of the results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AttemptAccount {
    /// Number of accepted trials, by the logs of their sessions.
    pub accepted: usize,
    /// Number of recordings analysed.
    pub analysed: usize,
    /// Number of analysed recordings with trials that were not accepted.
    pub not_accepted: usize,
    /// Number of attempts left out on purpose.
    pub excluded: usize,
    /// Attempts left out for another reason.
    pub left_out: Vec<OmittedAttempt>,
    /// Sessions without an accepted trial.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub empty_sessions: Vec<EmptySession>,
    /// Logs that cannot be read, with the consequence.
    pub unread_logs: Vec<String>,
}

impl AttemptAccount {
    /// Returns the attempts that should have been analysed but could not be.
    pub fn missed(&self) -> impl Iterator<Item = &OmittedAttempt> {
        self.left_out.iter().filter(|attempt| attempt.is_missed())
    }

    /// Returns lines with the numbers of trials accepted and analysed, and the reasons for leaving out the others.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut counts = format!("accepted {}, analysed {}", self.accepted, self.analysed);
        if self.not_accepted > 0 {
            counts += &format!(", {} of them not accepted", self.not_accepted);
        }
        let mut omissions: BTreeMap<String, usize> = BTreeMap::new();
        if self.excluded > 0 {
            omissions.insert("by decision".to_owned(), self.excluded);
        }
        for attempt in self.left_out.iter().filter(|attempt| !attempt.is_missed()) {
            let standing = attempt.standing.map(|standing| standing.to_string());
            *omissions.entry(standing.unwrap_or_default()).or_default() += 1;
        }
        let missed_count = self.missed().count();
        if missed_count > 0 {
            omissions.insert("missed".to_owned(), missed_count);
        }
        if !omissions.is_empty() {
            let words = omissions.iter().map(|(reason, n)| format!("{n} {reason}"));
            counts += &format!("; left out: {}", words.collect::<Vec<_>>().join(", "));
        }
        let missed_lines = missed_lines(self.missed()).into_iter();
        let missed_lines = missed_lines.map(|line| format!("  missed: {line}"));
        let empty_lines = self.empty_sessions.iter();
        let empty_lines = empty_lines.map(|session| format!("  {session}"));
        let lines = [counts].into_iter().chain(missed_lines);
        lines.chain(empty_lines).collect()
    }
}
