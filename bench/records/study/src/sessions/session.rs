//! History of a session, as its log states it.

use std::collections::{BTreeMap, BTreeSet};

use protocols::{Interval, TrialOutcome, TrialRecord};
use recording::study::TrialLabel;
use recording::study::event_log::{ExitStatus, Start};
use recording::sums::Sums;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::sessions::log_defect::LogDefect;
use crate::sessions::standing::Standing;

/// History of a session.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LoggedSession {
    /// First start; `None` if it is missing.
    pub start: Option<Start>,
    /// Last start: the first one, unless the session was resumed.
    pub last_start: Option<Start>,
    /// Number of resumptions.
    pub n_resumptions: usize,
    /// End of the session.
    pub end: SessionEnd,
    /// Planned trials, without practice; `None` if the log does not say.
    pub planned: Option<usize>,
    /// Attempts at trials, in the order of their starts.
    pub attempts: Vec<Attempt>,
    /// Settled attempts in the order of the log, from which the protocol resumes: an attempt with a withdrawn outcome
    /// occurs twice, and one that was never settled is interrupted.
    pub records: Vec<TrialRecord>,
    /// Fits, in the order of the log.
    pub fits: Vec<LoggedFit>,
    /// Last change of the carrier; `None` if a later part returned to the calibrated one.
    pub carrier_change: Option<CarrierChange>,
    /// Events out of order.
    pub defects: Vec<LogDefect>,
    /// Parts with a stop after the last attempt, which shows that everything was written.
    pub(super) stopped_parts: BTreeSet<usize>,
}

/// End of a session.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum SessionEnd {
    /// The session ended as its log says.
    Stopped {
        /// Exit status.
        status: ExitStatus,
        /// Reason, unless it succeeded.
        reason: Option<String>,
    },
    /// The program was killed, or is still running.
    Unfinished,
    /// No trial was begun.
    #[default]
    NotBegun,
}

/// Fit of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoggedFit {
    /// Attempt at the trial that had begun last; `None` if the log has no start of one.
    pub attempt: Option<TrialLabel>,
    /// Values of the event.
    pub data: Map<String, Value>,
}

/// Change of the carrier.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CarrierChange {
    /// Calibrated resonance of the part with the change, Hz; `None` if its start does not state it.
    pub calibrated_hz: Option<f64>,
    /// Values of the event.
    pub data: Map<String, Value>,
}

/// Attempt at a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Label of the attempt, which names its recording's folder.
    pub label: TrialLabel,
    /// Name of the condition.
    pub condition: String,
    /// Start of its recording relative to the session's first recording, s; `None` where the log has no plausible time.
    pub start_s: Option<f64>,
    /// Outcome; `None` where the log ends before it.
    pub outcome: Option<TrialOutcome>,
    /// Part of the session in which it was made, from 1; each resumption begins another.
    pub part: usize,
    /// Intervals marked in its recording.
    pub intervals: Vec<Interval>,
    /// Whether the log calls its recording saved.
    pub is_saved: bool,
    /// Whether the log calls its recording interrupted.
    pub is_interrupted: bool,
    /// Sums of its recording's files.
    pub sums: Option<Sums>,
}

impl Attempt {
    pub(super) fn new(label: TrialLabel, condition: String, part: usize) -> Self {
        Self {
            label,
            condition,
            start_s: None,
            outcome: None,
            part,
            intervals: Vec::new(),
            is_saved: false,
            is_interrupted: false,
            sums: None,
        }
    }

    /// Returns the standing of the attempt; an attempt that the log leaves open was interrupted.
    #[must_use]
    pub fn standing(&self) -> Standing {
        self.outcome
            .as_ref()
            .map_or(Standing::Interrupted, Standing::from_outcome)
    }

    /// Returns the verdict in a word, and its reasons, if there are any.
    #[must_use]
    pub fn verdict(&self) -> (&'static str, Vec<String>) {
        let texts = |reasons: &[protocols::RedoReason]| -> Vec<String> {
            reasons.iter().map(ToString::to_string).collect()
        };
        match &self.outcome {
            None => ("not settled", Vec::new()),
            Some(TrialOutcome::Accepted) => ("accepted", Vec::new()),
            // Nobody overruled the verdict on a practice trial, which is not repeated.
            Some(TrialOutcome::AcceptedAnyway { reasons }) if self.is_practice() => {
                ("rejected", texts(reasons))
            }
            Some(TrialOutcome::AcceptedAnyway { reasons }) => ("accepted anyway", texts(reasons)),
            Some(TrialOutcome::Redo { reasons }) if reasons.is_empty() => {
                ("repeated", vec!["as the operator asked".to_owned()])
            }
            Some(TrialOutcome::Redo { reasons }) => ("repeated", texts(reasons)),
            Some(TrialOutcome::GivenUp { reasons }) => ("given up", texts(reasons)),
            Some(TrialOutcome::Interrupted { interruption }) => {
                ("interrupted", vec![interruption.to_string()])
            }
        }
    }

    /// Returns whether the attempt is at a practice trial and its verdict rejected it: it is not repeated for that.
    #[must_use]
    pub fn is_rejected_practice(&self) -> bool {
        let is_rejected = matches!(self.outcome, Some(TrialOutcome::AcceptedAnyway { .. }));
        self.is_practice() && is_rejected
    }

    /// Returns whether the attempt is at a practice trial.
    #[must_use]
    pub fn is_practice(&self) -> bool {
        self.label.is_practice()
    }
}

impl LoggedSession {
    /// Returns the attempt with a label.
    #[must_use]
    pub fn attempt(&self, label: TrialLabel) -> Option<&Attempt> {
        self.attempts.iter().find(|attempt| attempt.label == label)
    }

    /// Returns the accepted attempts, one for each trial: the last, if there are several.
    #[must_use]
    pub fn accepted(&self) -> Vec<&Attempt> {
        let mut accepted = BTreeMap::new();
        for attempt in &self.attempts {
            if attempt.standing() == Standing::Accepted {
                accepted.insert((attempt.label.block, attempt.label.number), attempt);
            }
        }
        accepted.into_values().collect()
    }

    /// Returns whether the log has no verdict of an attempt, although its part of the session went on to another one.
    #[must_use]
    pub fn lacks_verdict(&self, attempt: &Attempt) -> bool {
        let attempts = self.attempts.iter();
        let later = attempts.skip_while(|candidate| candidate.label != attempt.label);
        attempt.outcome.is_none() && later.skip(1).any(|later| later.part == attempt.part)
    }

    /// Returns whether the log should call an attempt saved: it does so for other attempts of that time, and the program
    /// continued after this attempt or stopped in good order.
    #[must_use]
    pub fn should_be_saved(&self, attempt: &Attempt) -> bool {
        let mut saved_attempts = self.attempts.iter().filter(|candidate| candidate.is_saved);
        let is_later =
            |candidate: &Attempt| candidate.part == attempt.part && candidate.label > attempt.label;
        if self.stopped_parts.contains(&attempt.part) {
            saved_attempts.next().is_some()
        } else {
            saved_attempts.any(is_later)
        }
    }
}
