//! Keys of trials, the intervals marked in them, and the ends of their recordings.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Direction in which the finger slides; positions increase from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Towards increasing position.
    LeftToRight,
    /// Towards decreasing position.
    RightToLeft,
}

impl Direction {
    /// Returns +1 towards increasing position, −1 towards decreasing.
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

/// Key of one attempt at one trial. The pair of `number` and `attempt` is unique in a session.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TrialKey {
    /// Position in the session's order, from 1, practice trials first.
    pub number: u32,
    /// Attempt at this trial, from 1; increases with each repetition for any cause.
    pub attempt: u32,
    /// Whether this is a practice trial.
    pub practice: bool,
    /// Name of the condition.
    pub condition: String,
}

/// Kind of an interval of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum IntervalKind {
    /// The drive has settled and the finger is off the plate: Z_p is measured here.
    Unloaded,
    /// The slider moves and the finger follows.
    Exploration {
        /// Direction of the slider.
        direction: Direction,
    },
}

/// A marked interval, in seconds of the audio clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Kind of interval.
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
        /// The cause, as reported by the safety watch.
        reason: String,
    },
    /// The participant's display was lost.
    #[error("the participant's display was lost: {reason}")]
    DisplayLost {
        /// The display that was lost, and the cause.
        reason: String,
    },
    /// The finger stayed on the plate when it should have been off.
    #[error("finger not lifted in time")]
    FingerNotLifted,
    /// The finger was not placed, or the ready button not pressed, in time.
    #[error("finger not placed or ready button not pressed in time")]
    FingerNotPlaced,
    /// The recording was not saved, so that the trial cannot be used.
    #[error("not saved: {reason}")]
    NotSaved {
        /// The reason.
        reason: String,
    },
    /// The program ended during the trial.
    #[error("the program ended during the trial")]
    Crash,
}

/// End of a trial's recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum TrialEnd {
    /// Every exploration was made; the trial can be analysed.
    Completed,
    /// The trial was interrupted and will be repeated.
    Interrupted {
        /// The cause of the interruption.
        #[serde(flatten)]
        interruption: Interruption,
    },
}
