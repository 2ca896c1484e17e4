//! Events of a session in the event log.

use super::observation::OperatorCommand;
use super::phase::Phase;
use crate::record::{TrialOutcome, TrialRecord};
use crate::summary::SessionSummary;
use crate::trial::{Interruption, Interval, TrialKey};
use participants::ParticipantId;
use serde::{Deserialize, Serialize};

/// An event of a session and its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionEvent {
    /// Time on the audio clock, s.
    pub t_s: f64,
    /// Kind of event.
    #[serde(flatten)]
    pub kind: SessionEventKind,
}

/// Kind of an event of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum SessionEventKind {
    /// The first step of a session or of its continuation.
    SessionStarted {
        /// The participant.
        participant: ParticipantId,
        /// Name of the protocol.
        protocol: String,
        /// Seed of the order.
        seed: u64,
        /// Conditions of all trials in order, practice included.
        order: Vec<String>,
        /// Number of attempts restored from an earlier part of the session.
        resumed_attempts: usize,
    },
    /// The consent was recorded.
    ConsentGiven {
        /// Name of the person who recorded it.
        by: String,
    },
    /// The session entered another phase.
    Phase {
        /// The phase entered.
        phase: Phase,
    },
    /// A recording was opened.
    TrialBegan {
        /// The attempt.
        key: TrialKey,
    },
    /// An interval was marked in the open recording.
    Marked {
        /// The interval.
        interval: Interval,
    },
    /// An attempt was settled, or a later part of the session withdrew its outcome: the last event of an attempt counts.
    TrialSettled {
        /// The attempt and its outcome.
        record: TrialRecord,
    },
    /// The finger left the plate during the countdown.
    FingerLiftedEarly,
    /// The finger stayed on the plate after an exploration.
    FingerNotLifted,
    /// The dead-man switch was not released and held in time; the session paused.
    DeadManNotHeld,
    /// The hour's driving time does not allow another trial; the session paused.
    DrivingTimeSpent {
        /// Time after which another trial is allowed, s.
        wait_s: f64,
    },
    /// The recorder lags too far behind for another trial to begin.
    RecorderBehind {
        /// Audio that is not on the disk yet, or time since the recorder last answered, s.
        lag_s: f64,
        /// Whether it did not catch up in time; the session paused.
        paused: bool,
    },
    /// The safety chain tripped.
    SafetyTripped {
        /// The cause.
        reason: String,
    },
    /// The participant's display is lost; the session paused.
    DisplayLost {
        /// The display that is lost, and the cause.
        reason: String,
    },
    /// The participant's display is back; the session waits for the operator.
    DisplayBack,
    /// The operator asked for a pause at the end of the attempt.
    PauseAwaited {
        /// The attempt.
        key: TrialKey,
    },
    /// A command of the operator was refused.
    CommandRefused {
        /// The command.
        command: OperatorCommand,
        /// Why it was refused.
        because: String,
    },
    /// The session ended.
    SessionEnded {
        /// How it ended.
        outcome: SessionOutcome,
    },
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum SessionOutcome {
    /// Every trial is settled.
    Completed {
        /// Counts and means over its attempts.
        summary: SessionSummary,
    },
    /// The operator ended it.
    Aborted {
        /// Counts and means over its attempts.
        summary: SessionSummary,
    },
}

/// Attempts of a session, read event by event.
#[derive(Clone, Debug, Default)]
pub struct AttemptRecords {
    records: Vec<TrialRecord>,
    open: Option<TrialKey>,
}

impl AttemptRecords {
    /// Reads the next event.
    pub fn read(&mut self, event: &SessionEventKind) {
        match event {
            SessionEventKind::TrialBegan { key } => {
                let unsettled = self.open.replace(key.clone());
                self.records.extend(unsettled.map(crash_record));
            }
            SessionEventKind::TrialSettled { record } => {
                // A later part withdraws an outcome after the previous part was cut off.
                let unsettled = self.open.take().filter(|key| *key != record.key);
                self.records.extend(unsettled.map(crash_record));
                self.records.push(record.clone());
            }
            _ => {}
        }
    }

    /// Returns the attempts, from which to resume the session. An attempt that was never settled, because the program
    /// ended, becomes an interrupted one; an attempt with a withdrawn outcome occurs twice.
    pub fn records(mut self) -> Vec<TrialRecord> {
        self.records.extend(self.open.map(crash_record));
        self.records
    }
}

/// Returns the attempts in the events of a session: [`AttemptRecords::records`].
pub fn records_from_events<'a>(
    events: impl IntoIterator<Item = &'a SessionEventKind>,
) -> Vec<TrialRecord> {
    let mut records = AttemptRecords::default();
    for event in events {
        records.read(event);
    }
    records.records()
}

fn crash_record(key: TrialKey) -> TrialRecord {
    TrialRecord {
        key,
        outcome: TrialOutcome::Interrupted {
            interruption: Interruption::Crash,
        },
        analysis: None,
    }
}
