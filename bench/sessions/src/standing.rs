//! What became of an attempt at a trial.

use std::fmt;

use protocols::TrialOutcome;

/// What became of an attempt at a trial, by the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// The session went on with the next trial after it.
    Accepted,
    /// To be repeated.
    Repeated,
    /// Rejected, with no repetition left.
    GivenUp,
    /// Cut short, or left open where the log ends.
    Interrupted,
    /// The log does not know it.
    Unknown,
}

impl Standing {
    /// Returns the standing of an attempt that was settled so.
    #[must_use]
    pub fn of(outcome: &TrialOutcome) -> Self {
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
