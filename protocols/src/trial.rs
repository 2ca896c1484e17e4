//! What a trial is called, what is marked in it, and how it ended.

use crate::verdict::{RedoReason, TrialAnalysis};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Which way the finger slides; positions increase from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Towards increasing position.
    LeftToRight,
    /// Towards decreasing position.
    RightToLeft,
}

impl Direction {
    /// +1 towards increasing position, −1 towards decreasing.
    pub fn sign(self) -> f64 {
        match self {
            Self::LeftToRight => 1.0,
            Self::RightToLeft => -1.0,
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::LeftToRight => "left to right",
            Self::RightToLeft => "right to left",
        })
    }
}

/// One attempt at one trial. `number` and `attempt` together occur once in a session.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TrialKey {
    /// Place in the session's order, from 1, practice trials first.
    pub number: u32,
    /// From 1; grows with each repetition, whatever its cause.
    pub attempt: u32,
    /// Whether this is a practice trial.
    pub practice: bool,
    /// Name of the condition.
    pub condition: String,
}

/// What an interval of a recording holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum IntervalKind {
    /// Drive on and settled, no finger: where Z_p is read.
    Unloaded,
    /// The slider moves and the finger follows.
    Exploration {
        /// Which way.
        direction: Direction,
    },
}

/// A marked interval, in seconds of the audio clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// What it holds.
    #[serde(flatten)]
    pub kind: IntervalKind,
    /// Start, s.
    pub start_s: f64,
    /// End, s; after the start.
    pub end_s: f64,
}

/// Why a trial ended before its last exploration was over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "interruption", rename_all = "snake_case")]
pub enum Interruption {
    /// The operator paused.
    #[error("paused by the operator")]
    Paused,
    /// The operator asked for the trial to be repeated while it ran.
    #[error("repeated by the operator")]
    Redo,
    /// The operator aborted the session.
    #[error("session aborted by the operator")]
    Aborted,
    /// A safety device tripped.
    #[error("safety tripped: {reason}")]
    Safety {
        /// What tripped, as the safety thread said it.
        reason: String,
    },
    /// The finger stayed on the plate when it should have been off.
    #[error("finger not lifted in time")]
    FingerNotLifted,
    /// The finger or the ready button did not come.
    #[error("finger not placed or ready button not pressed in time")]
    FingerNotPlaced,
    /// The programme ended in the middle of the trial.
    #[error("the programme ended during the trial")]
    Crash,
}

/// How the recording of a trial ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum TrialEnd {
    /// All explorations were made; the trial can be analysed.
    Completed,
    /// It was cut short and will be repeated.
    Interrupted {
        /// Why.
        #[serde(flatten)]
        interruption: Interruption,
    },
}

/// What became of an attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum TrialOutcome {
    /// Judged good.
    Accepted,
    /// Judged bad, kept by the operator or because it is a practice trial; `reasons` say what was wrong.
    AcceptedAnyway {
        /// What the verdict held against it.
        reasons: Vec<RedoReason>,
    },
    /// To be repeated. Empty `reasons` mean that the operator alone wanted it.
    Redo {
        /// What the verdict held against it.
        reasons: Vec<RedoReason>,
    },
    /// Judged bad with no repetition left.
    GivenUp {
        /// What the verdict held against it.
        reasons: Vec<RedoReason>,
    },
    /// Cut short; to be repeated without counting against the redo limits.
    Interrupted {
        /// Why.
        #[serde(flatten)]
        interruption: Interruption,
    },
}

impl TrialOutcome {
    /// Whether the session goes on to the next trial after this outcome.
    pub fn settles(&self) -> bool {
        matches!(
            self,
            Self::Accepted | Self::AcceptedAnyway { .. } | Self::GivenUp { .. }
        )
    }
}

/// One attempt as the event log keeps it; enough to resume a session from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// Which attempt.
    pub key: TrialKey,
    /// What became of it.
    pub outcome: TrialOutcome,
    /// What the bench measured, absent when the attempt was not analysed.
    pub analysis: Option<TrialAnalysis>,
}
