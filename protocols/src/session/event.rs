//! What the session leaves in the event log.

use super::interface::{OperatorCommand, Phase, SessionOutcome};
use crate::participant::ParticipantId;
use crate::trial::{Interruption, Interval, TrialKey, TrialOutcome, TrialRecord};
use serde::{Deserialize, Serialize};

/// An event and when it happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionEvent {
    /// Time on the audio clock, s.
    pub t_s: f64,
    /// What happened.
    #[serde(flatten)]
    pub kind: SessionEventKind,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum SessionEventKind {
    /// The first step of a session or of its continuation.
    SessionStarted {
        /// Who takes part.
        participant: ParticipantId,
        /// Name of the protocol.
        protocol: String,
        /// Seed of the order.
        seed: u64,
        /// Conditions of all trials in order, practice included.
        order: Vec<String>,
        /// Attempts taken over from an earlier part of the session.
        resumed_attempts: usize,
    },
    /// The consent was recorded.
    ConsentGiven {
        /// By whom.
        by: String,
    },
    /// The session went into another phase.
    Phase {
        /// Which.
        phase: Phase,
    },
    /// A recording was opened.
    TrialBegan {
        /// Of which attempt.
        key: TrialKey,
    },
    /// An interval was marked in the open recording.
    Marked {
        /// Which.
        interval: Interval,
    },
    /// It is decided what became of an attempt.
    TrialSettled {
        /// What became of it.
        record: TrialRecord,
    },
    /// The finger left the plate during the countdown.
    FingerLiftedEarly,
    /// The finger stayed on the plate after an exploration.
    FingerNotLifted,
    /// The safety chain tripped.
    SafetyTripped {
        /// Why.
        reason: String,
    },
    /// The operator asked for what cannot be done now.
    CommandRefused {
        /// What was asked for.
        command: OperatorCommand,
        /// Why not.
        because: String,
    },
    /// The session ended.
    SessionEnded {
        /// How.
        outcome: SessionOutcome,
    },
}

/// The attempts that an event log tells of, to resume from. An attempt that began and was never settled, because the
/// programme ended, becomes an interrupted one.
pub fn records_from_events<'a>(
    events: impl IntoIterator<Item = &'a SessionEventKind>,
) -> Vec<TrialRecord> {
    let mut records: Vec<TrialRecord> = Vec::new();
    let mut open: Option<TrialKey> = None;
    for event in events {
        match event {
            SessionEventKind::TrialBegan { key } => {
                records.extend(open.replace(key.clone()).map(crashed));
            }
            SessionEventKind::TrialSettled { record } => {
                open.take_if(|key| *key == record.key);
                records.push(record.clone());
            }
            _ => {}
        }
    }
    records.extend(open.map(crashed));
    records
}

fn crashed(key: TrialKey) -> TrialRecord {
    TrialRecord {
        key,
        outcome: TrialOutcome::Interrupted {
            interruption: Interruption::Crash,
        },
        analysis: None,
    }
}
