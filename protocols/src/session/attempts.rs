//! Attempts at the trials of a session, and the next one.

use super::error::{RecordMismatch, SessionError};
use super::plan::PlannedTrial;
use crate::protocol::{Condition, RedoLimits, Rest};
use crate::record::{TrialOutcome, TrialRecord};
use crate::trial::{Interruption, TrialKey};
use std::collections::BTreeMap;

/// The trials of a session and the attempts at them.
#[derive(Clone, Debug)]
pub(super) struct Attempts {
    plan: Vec<PlannedTrial>,
    records: Vec<TrialRecord>,
    /// Last attempt number to skip, by trial number.
    omitted: BTreeMap<u32, u32>,
    /// Whether each trial of `plan` is settled.
    is_settled: Vec<bool>,
    /// Index in `plan` of the next or running trial: the first that is not settled.
    cursor: usize,
}

impl Attempts {
    /// Returns a session's trials without attempts.
    pub(super) fn new(plan: Vec<PlannedTrial>) -> Self {
        Self {
            is_settled: vec![false; plan.len()],
            plan,
            records: Vec::new(),
            omitted: BTreeMap::new(),
            cursor: 0,
        }
    }

    /// Adds an attempt of an earlier part of the session, or withdraws its outcome.
    ///
    /// # Errors
    /// [`SessionError::ForeignRecord`] if the attempt is not the one that was due.
    pub(super) fn restore(&mut self, record: &TrialRecord) -> Result<(), SessionError> {
        let foreign = |because| {
            Err(SessionError::ForeignRecord {
                key: record.key.clone(),
                because,
            })
        };
        if let TrialOutcome::Interrupted { interruption } = &record.outcome
            && self.withdraw(&record.key, interruption).is_some()
        {
            return Ok(());
        }
        if self.all_settled() {
            return foreign(RecordMismatch::AllSettled {
                trials: self.plan.len(),
            });
        }
        let next = self.next_key();
        if record.key.number != next.number {
            return foreign(RecordMismatch::Trial {
                number: next.number,
            });
        }
        if record.key.condition != next.condition || record.key.practice != next.practice {
            return foreign(RecordMismatch::Condition {
                condition: next.condition,
                practice: next.practice,
            });
        }
        if record.key.attempt < next.attempt {
            return foreign(RecordMismatch::Attempt { next: next.attempt });
        }
        self.add(record.clone());
        Ok(())
    }

    /// Excludes the attempts up to `attempt` at trial `number`.
    pub(super) fn leave_out(&mut self, number: u32, attempt: u32) {
        let last = self.omitted.entry(number).or_default();
        *last = attempt.max(*last);
    }

    /// Adds an attempt; one that settles its trial moves on to the next.
    pub(super) fn add(&mut self, record: TrialRecord) {
        if record.outcome.settles() {
            self.settle(record.key.number, true);
        }
        self.records.push(record);
    }

    /// Withdraws the outcome of an attempt that settled its trial, so that the trial is repeated; returns the attempt
    /// as it counts now, or `None` if no such attempt settled its trial.
    pub(super) fn withdraw(
        &mut self,
        key: &TrialKey,
        interruption: &Interruption,
    ) -> Option<TrialRecord> {
        let mut records = self.records.iter_mut();
        let record = records.find(|record| record.key == *key && record.outcome.settles())?;
        record.outcome = TrialOutcome::Interrupted {
            interruption: interruption.clone(),
        };
        record.analysis = None;
        let record = record.clone();
        self.settle(key.number, false);
        Some(record)
    }

    fn settle(&mut self, number: u32, is_settled: bool) {
        self.is_settled[number as usize - 1] = is_settled;
        let next = self.is_settled.iter().position(|is_settled| !is_settled);
        self.cursor = next.unwrap_or(self.plan.len());
    }

    /// Returns the attempts so far, restored ones included.
    pub(super) fn records(&self) -> &[TrialRecord] {
        &self.records
    }

    /// Returns all trials in order.
    pub(super) fn plan(&self) -> &[PlannedTrial] {
        &self.plan
    }

    /// Returns the number of trials left.
    pub(super) fn trials_left(&self) -> u32 {
        self.is_settled
            .iter()
            .filter(|is_settled| !**is_settled)
            .count() as u32
    }

    /// Whether no trial is left.
    pub(super) fn all_settled(&self) -> bool {
        self.cursor == self.plan.len()
    }

    /// Returns the number of the next or running trial, and of the one after it; past the end, the number after the last trial.
    pub(super) fn next_numbers(&self) -> (u32, u32) {
        let next_index = (self.cursor + 1..self.plan.len()).find(|&index| !self.is_settled[index]);
        let next_index = next_index.unwrap_or(self.plan.len());
        (self.cursor as u32 + 1, next_index as u32 + 1)
    }

    /// Returns the condition of the next or running trial.
    ///
    /// # Panics
    /// If every trial is settled.
    pub(super) fn condition(&self) -> &Condition {
        &self.plan[self.cursor].condition
    }

    /// Returns the key of the next attempt.
    ///
    /// # Panics
    /// If every trial is settled.
    pub(super) fn next_key(&self) -> TrialKey {
        let trial = &self.plan[self.cursor];
        let number = self.cursor as u32 + 1;
        let attempts = self
            .records
            .iter()
            .filter(|r| r.key.number == number)
            .map(|r| r.key.attempt);
        let last = attempts.chain(self.omitted.get(&number).copied());
        TrialKey {
            number,
            attempt: last.max().unwrap_or(0) + 1,
            practice: trial.practice,
            condition: trial.condition.name.clone(),
        }
    }

    /// Whether a verdict may repeat trial `number` once more.
    pub(super) fn redo_left(&self, number: u32, limits: RedoLimits) -> bool {
        self.redos_left(number, limits).0 > 0
    }

    /// Returns the number of repetitions by verdicts left for trial `number`, and for all trials together.
    pub(super) fn redos_left(&self, number: u32, limits: RedoLimits) -> (u32, u32) {
        let redone = |of_trial: bool| {
            let redone = self
                .records
                .iter()
                .filter(|r| matches!(r.outcome, TrialOutcome::Redo { .. }))
                .filter(|r| !of_trial || r.key.number == number);
            redone.count() as u32
        };
        let in_session = limits.max_total.saturating_sub(redone(false));
        let of_trial = limits.max_per_trial.saturating_sub(redone(true));
        (of_trial.min(in_session), in_session)
    }

    /// Returns the largest number of repetitions by verdicts that the trials left can use; practice is not repeated.
    pub(super) fn usable_redos(&self, limits: RedoLimits) -> u32 {
        let trials = self.plan.iter().zip(&self.is_settled).zip(1..);
        let left = trials.filter(|((trial, is_settled), _)| !trial.practice && !**is_settled);
        left.map(|(_, number)| self.redos_left(number, limits).0)
            .fold(0, u32::saturating_add)
    }

    /// Whether a break comes before the next trial.
    pub(super) fn rest_is_due(&self, rest: Rest) -> bool {
        let practice = self.plan.iter().filter(|trial| trial.practice).count();
        !self.all_settled()
            && rest.is_due_after(self.plan.len() as u32 - self.trials_left(), practice as u32)
    }
}
