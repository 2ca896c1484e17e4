//! How attempts at trials were settled, as the event log keeps them.

use crate::analysis::TrialAnalysis;
use crate::redo_reason::RedoReason;
use crate::trial::{Interruption, TrialKey};
use serde::{Deserialize, Serialize};

/// How an attempt was settled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum TrialOutcome {
    /// Accepted by the verdict.
    Accepted,
    /// Rejected by the verdict, but kept by the operator or because it is a practice trial.
    AcceptedAnyway {
        /// Why the verdict rejected it.
        reasons: Vec<RedoReason>,
    },
    /// To be repeated. `reasons` is empty when the verdict was good and the operator asked for the repetition.
    Redo {
        /// Why the verdict rejected it.
        reasons: Vec<RedoReason>,
    },
    /// Rejected by the verdict, with no repetition left.
    GivenUp {
        /// Why the verdict rejected it.
        reasons: Vec<RedoReason>,
    },
    /// Cut short; to be repeated without counting against the redo limits.
    Interrupted {
        /// What cut it short.
        #[serde(flatten)]
        interruption: Interruption,
    },
}

impl TrialOutcome {
    /// Whether the session moves on to the next trial after this outcome.
    pub fn settles(&self) -> bool {
        matches!(
            self,
            Self::Accepted | Self::AcceptedAnyway { .. } | Self::GivenUp { .. }
        )
    }
}

/// One attempt as the event log keeps it; the records of a session are enough to resume it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// The attempt.
    pub key: TrialKey,
    /// How it was settled.
    pub outcome: TrialOutcome,
    /// What the bench measured; `None` when the attempt was not analysed.
    pub analysis: Option<TrialAnalysis>,
}
