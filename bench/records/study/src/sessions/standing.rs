//! Standing of an attempt at a trial.

use std::fmt;

use protocols::TrialOutcome;
use serde::{Deserialize, Serialize};

/// Standing of an attempt at a trial by the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// Accepted: the session continued with the next trial.
    Accepted,
    /// Rejected, to be repeated.
    Repeated,
    /// Rejected, with no repetition left.
    #[serde(rename = "given up")]
    GivenUp,
    /// Cut short, or still open where the log ends.
    Interrupted,
    /// Not in the log.
    Unknown,
}

impl Standing {
    /// Returns the standing of an attempt with this outcome.
    #[must_use]
    pub fn from_outcome(outcome: &TrialOutcome) -> Self {
        match outcome {
            TrialOutcome::Accepted | TrialOutcome::AcceptedAnyway { .. } => Self::Accepted,
            TrialOutcome::Redo { .. } => Self::Repeated,
            TrialOutcome::GivenUp { .. } => Self::GivenUp,
            TrialOutcome::Interrupted { .. } => Self::Interrupted,
        }
    }
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Accepted => "accepted",
            Self::Repeated => "repeated",
            Self::GivenUp => "given up",
            Self::Interrupted => "interrupted",
            Self::Unknown => "unknown",
        })
    }
}
