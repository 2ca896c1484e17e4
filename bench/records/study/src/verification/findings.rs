//! Findings of a verification on trials, sessions and a study.

use std::fmt;
use std::path::PathBuf;

use crate::sessions::{SessionEnd, Standing};

use crate::verification::defect::{RecordingDefect, SessionDefect, StudyDefect};
use recording::study::{TrialBlock, TrialLabel};

/// Integrity of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrity {
    /// Every file has the sum in the log.
    Intact,
    /// The recording can be read; the log has no sums for it.
    NoSum,
    /// The recording has defects.
    Damaged,
    /// The recording was made, but does not exist any longer.
    Missing,
    /// The attempt ended before recording began.
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
    /// Attempt, which names its folder.
    pub label: TrialLabel,
    /// Standing of the attempt.
    pub standing: Standing,
    /// Integrity of its recording.
    pub integrity: Integrity,
    /// Defects of its recording.
    pub defects: Vec<RecordingDefect>,
    /// Notes that are not defects.
    pub notes: Vec<String>,
}

/// Findings of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionFindings {
    /// Folder of the session.
    pub folder: PathBuf,
    /// End of the session.
    pub end: SessionEnd,
    /// Planned trials, without practice; `None` if the log does not say.
    pub planned: Option<usize>,
    /// Attempts, in order.
    pub trials: Vec<TrialFindings>,
    /// Defects of the session, apart from its recordings.
    pub defects: Vec<SessionDefect>,
    /// Notes that are not defects.
    pub notes: Vec<String>,
}

impl SessionFindings {
    /// Returns whether the session has no defects, recordings included.
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
    /// Sessions of the study, in order.
    pub sessions: Vec<SessionFindings>,
    /// Defects of the study itself, not of its sessions.
    pub defects: Vec<StudyDefect>,
    /// Notes that are not defects.
    pub notes: Vec<String>,
}

impl StudyFindings {
    /// Returns whether the study has no defects, sessions included.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.defects.is_empty() && self.sessions.iter().all(SessionFindings::is_whole)
    }
}
