//! Defects in the order of a session's log.

use std::borrow::Cow;

use recording::study::TrialLabel;
use serde::{Deserialize, Serialize};

/// Defect in the order of a session's log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum LogDefect {
    /// The log does not begin with a start, or continues without one after a stop.
    #[error(
        "events.jsonl, document {document}: an event or a stop before any start; lines are missing or in another order"
    )]
    NoStart {
        /// The document, from 1.
        document: usize,
    },
    /// Event numbers are missing, duplicated or out of order.
    #[error(
        "events.jsonl: event {found} follows where event {expected} belongs: lines are missing or in another order"
    )]
    Number {
        /// Expected number.
        expected: u64,
        /// Number in the log.
        found: u64,
    },
    /// The audio clock goes back between two events.
    #[error(
        "events.jsonl, event {number}: its time {audio_s:.6} s is before the last event's, {before_s:.6} s"
    )]
    Time {
        /// Number of the event.
        number: u64,
        /// Time of the event, s.
        audio_s: f64,
        /// Time of the event before it, s.
        before_s: f64,
    },
    /// The stream of an event has no descriptor.
    #[error("events.jsonl, event {number}: stream `{stream}` has no descriptor before it")]
    Undescribed {
        /// Number of the event.
        number: u64,
        /// Stream of the event.
        stream: String,
    },
    /// The number of events in a stop differs from the number in the log.
    #[error("events.jsonl: {found} events before a stop that counts {expected}: lines are missing")]
    Count {
        /// Number in the stop.
        expected: u64,
        /// Number in the log.
        found: u64,
    },
    /// A stop calls the session complete although some of its trials were not settled.
    #[error(
        "events.jsonl calls the session complete, and {settled} of its {planned} trials were settled"
    )]
    NotAllSettled {
        /// Planned trials.
        planned: usize,
        /// Settled trials.
        settled: usize,
    },
    /// A trial was begun, settled or saved out of order.
    #[error("events.jsonl, event {number}: {trial} {fault}")]
    Order {
        /// Number of the event.
        number: u64,
        /// The trial.
        trial: TrialLabel,
        /// Description of the fault.
        fault: Cow<'static, str>,
    },
}

impl LogDefect {
    /// Returns whether the defect may hide trials: lines of the log are missing or out of order.
    #[must_use]
    pub fn hides_trials(&self) -> bool {
        matches!(
            self,
            Self::NoStart { .. } | Self::Number { .. } | Self::Count { .. } | Self::Order { .. }
        )
    }
}
