//! What a verification found of trials, sessions and a study.

use std::fmt;
use std::path::PathBuf;

use ::sessions::Standing;

use crate::defect::{RecordingDefect, SessionDefect, StudyDefect};
use recording::study::event_log::ExitStatus;
use recording::study::{TrialBlock, TrialLabel};

/// Whether a recording is as it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrity {
    /// Every file has the sum in the log.
    Intact,
    /// It can be read; the log has no sums of it.
    NoSum,
    /// Something is wrong with it.
    Damaged,
    /// It was recorded and is not there.
    Missing,
    /// The attempt ended before anything was recorded.
    NotRecorded,
}

impl fmt::Display for Integrity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Intact => "sums agree",
            Self::NoSum => "no sum recorded",
            Self::Damaged => "DAMAGED",
            Self::Missing => "MISSING",
            Self::NotRecorded => "not recorded",
        })
    }
}

/// Findings of one attempt at a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialFindings {
    /// The attempt, which names its folder.
    pub label: TrialLabel,
    /// What became of it.
    pub standing: Standing,
    /// Whether its recording is as it was made.
    pub integrity: Integrity,
    /// What is wrong with it.
    pub defects: Vec<RecordingDefect>,
    /// What is worth knowing and not wrong.
    pub notes: Vec<String>,
}

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SessionEnd {
    /// As its log says.
    Stopped {
        /// How.
        status: ExitStatus,
        /// Why, unless it succeeded.
        reason: Option<String>,
    },
    /// The program was killed, or is still at it.
    Unfinished,
    /// Nothing was begun.
    NotBegun,
}

/// Findings of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionFindings {
    /// Its folder.
    pub folder: PathBuf,
    /// How it ended.
    pub end: SessionEnd,
    /// Trials in its order, without practice; `None` if the log does not say.
    pub planned: Option<usize>,
    /// Attempts, in order.
    pub trials: Vec<TrialFindings>,
    /// What is wrong with it beside its recordings.
    pub defects: Vec<SessionDefect>,
    /// What is worth knowing and not wrong.
    pub notes: Vec<String>,
}

impl SessionFindings {
    /// Returns whether nothing is damaged or missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.defects.is_empty() && self.trials.iter().all(|trial| trial.defects.is_empty())
    }

    /// Returns the number of accepted trials, without practice.
    #[must_use]
    pub fn accepted(&self) -> usize {
        let trials = self.trials.iter();
        trials
            .filter(|trial| trial.label.block == TrialBlock::Main)
            .filter(|trial| trial.standing == Standing::Accepted)
            .count()
    }
}

/// Findings of a study.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StudyFindings {
    /// Its sessions, in order.
    pub sessions: Vec<SessionFindings>,
    /// What is wrong with it beside them.
    pub defects: Vec<StudyDefect>,
    /// What is worth knowing and not wrong.
    pub notes: Vec<String>,
}

impl StudyFindings {
    /// Returns whether nothing is damaged or missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.defects.is_empty() && self.sessions.iter().all(SessionFindings::is_whole)
    }
}
