//! Attempts at trials by their outcome: which are analysed, which are left out, and why.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};
use sessions::Standing;

use crate::analysed::Analysed;

/// Attempt with a recording that is analysed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taken {
    /// Folder of its recording.
    pub path: PathBuf,
    /// Outcome of the attempt; `None` without a log that records it.
    pub standing: Option<Standing>,
}

/// Attempt that is left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Folder of its recording, which may be missing.
    pub path: PathBuf,
    /// Outcome of the attempt; `None` without a log that records it.
    #[serde(serialize_with = "in_words")]
    pub standing: Option<Standing>,
    /// Reason for leaving it out.
    pub because: String,
}

impl LeftOut {
    /// Returns whether this is an error: an accepted trial is always analysed, unless it was excluded on purpose.
    #[must_use]
    pub fn is_missed(&self) -> bool {
        matches!(self.standing, None | Some(Standing::Accepted))
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(standing) = self.standing {
            write!(f, " ({standing})")?;
        }
        write!(f, ": {}", self.because)
    }
}

fn in_words<S: Serializer>(of: &Option<Standing>, serializer: S) -> Result<S::Ok, S::Error> {
    match of {
        Some(standing) => serializer.collect_str(standing),
        None => serializer.serialize_none(),
    }
}

/// Attempts found in the folders given for an analysis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Attempts {
    /// Attempts that are analysed, in order.
    pub taken: Vec<Taken>,
    /// Attempts that are left out.
    pub left_out: Vec<LeftOut>,
    /// Logs that cannot be read, with the reason: the accepted attempts of their sessions are unknown.
    pub unread_logs: Vec<(PathBuf, String)>,
}

impl Attempts {
    /// Returns the recordings that are analysed.
    #[must_use]
    pub fn recordings(&self) -> Vec<PathBuf> {
        self.taken.iter().map(|of| of.path.clone()).collect()
    }

    /// Adds further attempts, except those in `seen` folders.
    pub(crate) fn extend(&mut self, new: Self, seen: &mut HashSet<PathBuf>) {
        let taken = new.taken.into_iter();
        self.taken
            .extend(taken.filter(|of| seen.insert(canonical(&of.path))));
        let left_out = new.left_out.into_iter();
        self.left_out
            .extend(left_out.filter(|of| seen.insert(canonical(&of.path))));
        for log in new.unread_logs {
            if !self.unread_logs.contains(&log) {
                self.unread_logs.push(log);
            }
        }
    }

    /// Returns the account of all attempts in an analysis; `excluded` are recordings left out on purpose.
    #[must_use]
    pub fn account(&self, analysed: &Analysed, excluded: &[PathBuf]) -> Account {
        let accepted = |standing: Option<Standing>| standing == Some(Standing::Accepted);
        let mut account = Account {
            accepted: self.taken.iter().filter(|of| accepted(of.standing)).count()
                + (self.left_out.iter().filter(|of| accepted(of.standing))).count(),
            analysed: 0,
            not_accepted: 0,
            excluded: excluded.len(),
            left_out: Vec::new(),
            unread_logs: self.unread_logs.iter().map(log_words).collect(),
        };
        let standings: BTreeMap<&Path, Option<Standing>> = self
            .taken
            .iter()
            .map(|of| (of.path.as_path(), of.standing))
            .collect();
        for recording in &analysed.recordings {
            let standing = standings.get(recording.path.as_path()).copied().flatten();
            match &recording.found {
                Ok(_) => {
                    account.analysed += 1;
                    account.not_accepted += usize::from(standing.is_some() && !accepted(standing));
                }
                Err(error) => account.left_out.push(LeftOut {
                    path: recording.path.clone(),
                    standing,
                    because: format!("it cannot be read: {error}"),
                }),
            }
        }
        let left_out = self.left_out.iter();
        let left_out = left_out.filter(|of| !excluded.contains(&of.path));
        account.left_out.extend(left_out.cloned());
        account
    }
}

fn log_words((path, reason): &(PathBuf, String)) -> String {
    format!(
        "{}: nothing tells which attempts were accepted, so the last completed one of each trial is analysed: {reason}",
        path.display()
    )
}

/// Returns a folder's canonical path, even if the folder does not exist.
fn canonical(path: &Path) -> PathBuf {
    let beside = || Some(path.parent()?.canonicalize().ok()?.join(path.file_name()?));
    let own = path.canonicalize().ok().or_else(beside);
    own.unwrap_or_else(|| path.to_owned())
}

/// Account of the attempts of an analysis, as in `attempts` of the results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Account {
    /// Number of accepted trials, by the logs of their sessions.
    pub accepted: usize,
    /// Number of recordings analysed.
    pub analysed: usize,
    /// Number of analysed recordings with trials that were not accepted.
    pub not_accepted: usize,
    /// Number of attempts left out on purpose.
    pub excluded: usize,
    /// Attempts left out for another reason.
    pub left_out: Vec<LeftOut>,
    /// Logs that cannot be read, with the consequence.
    pub unread_logs: Vec<String>,
}

impl Account {
    /// Returns the attempts that should have been analysed but could not be.
    pub fn missed(&self) -> impl Iterator<Item = &LeftOut> {
        self.left_out.iter().filter(|of| of.is_missed())
    }

    /// Returns lines with the numbers of trials accepted and analysed, and the reasons for leaving out the others.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut counts = format!("accepted {}, analysed {}", self.accepted, self.analysed);
        if self.not_accepted > 0 {
            counts += &format!(", {} of them not accepted", self.not_accepted);
        }
        let mut out: BTreeMap<String, usize> = BTreeMap::new();
        if self.excluded > 0 {
            out.insert("by decision".to_owned(), self.excluded);
        }
        for of in self.left_out.iter().filter(|of| !of.is_missed()) {
            let standing = of.standing.map(|standing| standing.to_string());
            *out.entry(standing.unwrap_or_default()).or_default() += 1;
        }
        let missed = self.missed().count();
        if missed > 0 {
            out.insert("missed".to_owned(), missed);
        }
        if !out.is_empty() {
            let words = out.iter().map(|(why, n)| format!("{n} {why}"));
            counts += &format!("; left out: {}", words.collect::<Vec<_>>().join(", "));
        }
        let missed = self.missed().map(|of| format!("  missed: {of}"));
        [counts].into_iter().chain(missed).collect()
    }
}
