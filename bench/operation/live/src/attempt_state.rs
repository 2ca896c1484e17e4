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
//! Batches are collected in `Recorded` and `Due`; the carrier changes in the other two. No other event changes the
//! state: after a verdict without an analysis in time, the late analysis stays unused.

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

#[cfg(test)]
mod tests {
    use super::*;
    use protocols::{Protocol, TrialKey};
    use recording::pipeline::Account;

    fn key() -> TrialKey {
        TrialKey {
            number: 1,
            attempt: 1,
            practice: false,
            condition: "c".to_owned(),
        }
    }

    fn begun() -> AttemptState {
        let text = protocols::built_in("demo").unwrap();
        let protocol = Protocol::parse(text, "demo.toml").unwrap();
        let record = AttemptRecord::new(&key(), &protocol, 29_000.0, Account::default());
        AttemptState::Recorded(record)
    }

    fn due_trial() -> DueTrial {
        DueTrial {
            key: key(),
            intervals: Vec::new(),
            at_s: 10.0,
        }
    }

    #[test]
    fn a_completed_attempt_takes_data_until_all_have_arrived() {
        let mut state = begun();
        assert!(state.take_due(20.0).is_none(), "not completed");
        state.complete(due_trial());
        assert!(state.take_due(10.0 + 0.9 * DATA_DELAY_S).is_none());
        assert!(state.record().is_some());
        let (record, due_trial) = state.take_due(10.0 + 1.1 * DATA_DELAY_S).unwrap();
        assert_eq!((record.carrier_hz, due_trial.at_s), (29_000.0, 10.0));
        assert!(matches!(state, AttemptState::Idle));
    }

    #[test]
    fn a_verdict_takes_the_analysis_once_and_no_open_attempt() {
        let mut state = begun();
        state.complete(due_trial());
        assert!(state.take_analysis().is_none());
        assert!(state.record().is_some(), "the data are still due");
        let (record, _) = state.take_due(11.0).unwrap();
        let rules = Protocol::parse(protocols::built_in("demo").unwrap(), "demo.toml")
            .unwrap()
            .selection_rules(0.0);
        let data = record.measurements;
        let analysis = analysis::trial_selection::analyse(&key(), &[], &data, &rules);
        state = AttemptState::Analysed(analysis);
        assert!(state.record().is_none());
        assert!(state.analysis().is_some());
        assert!(state.take_analysis().is_some());
        assert!(matches!(state, AttemptState::Idle));
    }

    #[test]
    fn without_an_attempt_in_progress_nothing_is_completed() {
        let mut state = AttemptState::Idle;
        state.complete(due_trial());
        assert!(matches!(state, AttemptState::Idle));
    }
}
