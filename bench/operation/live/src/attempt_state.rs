//! State of the latest attempt, from its first data to its verdict.
//!
//! | state | event | next state |
//! | --- | --- | --- |
//! | any | an attempt begins | `Recorded` |
//! | `Recorded` | the attempt is interrupted | `Idle` |
//! | `Recorded` | the attempt is completed | `Due` |
//! | `Due` | all data have arrived | `Analysed` |
//! | `Analysed` | the verdict is announced | `Idle` |
//!
//! Batches are collected in `Recorded` and `Due`; the carrier changes in the other two. Any other event leaves the state: a
//! verdict without an analysis in time leaves `Due`, and the late analysis stays unused.

use protocols::TrialAnalysis;

use crate::attempt_record::{AttemptRecord, DATA_DELAY_S};
use crate::due_trial::DueTrial;

/// State of the latest attempt.
#[derive(Default)]
pub enum AttemptState {
    /// No attempt, or its end is known.
    #[default]
    Idle,
    /// The attempt is in progress.
    Recorded(AttemptRecord),
    /// The attempt is completed, with data still on their way.
    Due(AttemptRecord, DueTrial),
    /// The attempt is analysed, and its verdict is to come.
    Analysed(TrialAnalysis),
}

impl AttemptState {
    /// Returns the record that takes the data, if there is one.
    pub fn record(&mut self) -> Option<&mut AttemptRecord> {
        match self {
            Self::Recorded(record) | Self::Due(record, _) => Some(record),
            Self::Idle | Self::Analysed(_) => None,
        }
    }

    /// Completes the attempt.
    pub fn complete(&mut self, due_trial: DueTrial) {
        *self = match std::mem::take(self) {
            Self::Recorded(record) => Self::Due(record, due_trial),
            state => state,
        };
    }

    /// Takes the completed attempt if all its data have arrived at `now_s`.
    pub fn take_due(&mut self, now_s: f64) -> Option<(AttemptRecord, DueTrial)> {
        match std::mem::take(self) {
            Self::Due(record, due_trial) if now_s >= due_trial.at_s + DATA_DELAY_S => {
                Some((record, due_trial))
            }
            state => {
                *self = state;
                None
            }
        }
    }

    /// Returns the analysis for the verdict.
    pub fn analysis(&self) -> Option<&TrialAnalysis> {
        match self {
            Self::Analysed(analysis) => Some(analysis),
            _ => None,
        }
    }

    /// Takes the analysis, because the verdict is announced.
    pub fn take_analysis(&mut self) -> Option<TrialAnalysis> {
        match std::mem::take(self) {
            Self::Analysed(analysis) => Some(analysis),
            state => {
                *self = state;
                None
            }
        }
    }
}
