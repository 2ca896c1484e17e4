//! Records of settled attempts, as written to the event log.

use crate::analysis::TrialAnalysis;
use crate::redo_reason::RedoReason;
use crate::trial::{Interruption, TrialKey};
use serde::{Deserialize, Serialize};

/// Outcome of an attempt.
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
    /// To be repeated. `reasons` is empty if the verdict was good and the operator asked for the repetition.
    Redo {
        /// Why the verdict rejected it.
        reasons: Vec<RedoReason>,
    },
    /// Rejected by the verdict, with no repetition left.
    GivenUp {
        /// Why the verdict rejected it.
        reasons: Vec<RedoReason>,
    },
    /// Interrupted; to be repeated without counting against the redo limits.
    Interrupted {
        /// The cause of the interruption.
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

/// Record of one attempt in the event log; the records of a session suffice to resume it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// The attempt.
    pub key: TrialKey,
    /// Outcome of the attempt.
    pub outcome: TrialOutcome,
    /// Results of the measurements; `None` if the attempt was not analysed.
    pub analysis: Option<TrialAnalysis>,
}
