//! Steps from a recorded trial to the next: analysis, verdict, break.

use super::action::{SessionAction, StepActions};
use super::machine::Session;
use super::observation::RecordingOutcome;
use super::state::{AfterHalt, State};
use crate::analysis::TrialAnalysis;
use crate::record::TrialOutcome;
use crate::redo_reason::RedoReason;
use crate::trial::{Interruption, TrialKey};
use crate::verdict::{Verdict, judge};

/// Longest time for a recording to be saved after its verdict stands, s of audio. Assumed: twice the length of the
/// recorder's queue, so that a disk that recovers before the queue overflows costs no trial.
pub(super) const LONGEST_SAVE_S: f64 = 20.0;

impl Session {
    /// Judges the attempt after its analysis has arrived or timed out.
    pub(super) fn advance_analysis(
        &mut self,
        key: TrialKey,
        since_s: f64,
        out: &mut StepActions,
    ) -> State {
        let analysis = self.analysis.take();
        let verdict = match &analysis {
            Some(analysis) => judge(analysis, &self.protocol.verdict_rules(&key.condition)),
            None if self.elapsed_s(since_s) > self.protocol.timeouts.analysis_s => Verdict::Redo {
                reasons: vec![RedoReason::NotAnalysed],
            },
            None => return State::Analysing { key, since_s },
        };
        self.analysis_key = None;
        out.push(SessionAction::Verdict {
            key: key.clone(),
            verdict: verdict.clone(),
        });
        let reasons = match verdict {
            Verdict::Accepted => Vec::new(),
            Verdict::Redo { reasons } => reasons,
        };
        State::Judged {
            key,
            analysis,
            reasons,
            since_s: self.now_s,
        }
    }

    /// Returns the outcome of a judged attempt unless it is overruled.
    pub(super) fn outcome(&self, key: &TrialKey, reasons: Vec<RedoReason>) -> TrialOutcome {
        if reasons.is_empty() {
            TrialOutcome::Accepted
        } else if key.practice {
            TrialOutcome::AcceptedAnyway { reasons }
        } else if self.attempts.redo_left(key.number, self.protocol.redo) {
            TrialOutcome::Redo { reasons }
        } else {
            TrialOutcome::GivenUp { reasons }
        }
    }

    /// Records an attempt and begins the next step: a break, a trial or the end. An attempt that settles its trial is
    /// recorded only after its recording is saved.
    pub(super) fn settle(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut StepActions,
    ) -> State {
        if self.awaits_save(&outcome) {
            return self.saving_state(key, analysis, outcome);
        }
        let settles = outcome.settles();
        self.record(key, analysis, outcome, out);
        if std::mem::take(&mut self.is_pause_due) && !self.attempts.all_settled() {
            return State::Halted {
                fault: false,
                sequel: self.sequel_of(settles),
            };
        }
        match self.sequel_of(settles) {
            AfterHalt::Trial => self.next_trial(out),
            AfterHalt::State(state) => *state,
        }
    }

    /// Records an attempt that was overruled while the session is halted; returns the step after the halt.
    pub(super) fn settle_halted(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut StepActions,
    ) -> AfterHalt {
        if self.awaits_save(&outcome) {
            return AfterHalt::State(Box::new(self.saving_state(key, analysis, outcome)));
        }
        let settles = outcome.settles();
        self.record(key, analysis, outcome, out);
        self.sequel_of(settles)
    }

    /// Returns whether an attempt with this outcome waits for its recording to be saved.
    pub(super) fn awaits_save(&self, outcome: &TrialOutcome) -> bool {
        outcome.settles() && self.recording_outcome != Some(RecordingOutcome::Saved)
    }

    fn saving_state(
        &self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
    ) -> State {
        State::Saving {
            key,
            analysis,
            outcome,
            since_s: self.now_s,
        }
    }

    /// Settles the attempt after its recording is saved; interrupts it if that takes too long.
    pub(super) fn advance_saving(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        since_s: f64,
        out: &mut StepActions,
    ) -> State {
        if !self.awaits_save(&outcome) {
            return self.settle(key, analysis, outcome, out);
        }
        if self.elapsed_s(since_s) > LONGEST_SAVE_S {
            let reason = format!("the recorder did not report it saved within {LONGEST_SAVE_S} s");
            self.record_unsaved(key, reason, out);
            return self.paused_before_trial();
        }
        State::Saving {
            key,
            analysis,
            outcome,
            since_s,
        }
    }

    /// Interrupts the current attempt, also of a halted session, if its recording has failed; returns whether that
    /// completed the step.
    pub(super) fn recording_failed(&mut self, out: &mut StepActions) -> bool {
        let Some(RecordingOutcome::Failed(reason)) = &self.recording_outcome else {
            return false;
        };
        let reason = reason.clone();
        self.recording_outcome = None;
        let (halt_fault, state) = match self.take_state() {
            State::Halted {
                fault,
                sequel: AfterHalt::State(state),
            } => (Some(fault), *state),
            state => (None, state),
        };
        match state {
            State::Trial { open, .. } => {
                self.interrupt(open, Interruption::NotSaved { reason }, out);
            }
            State::Analysing { key, .. }
            | State::Judged { key, .. }
            | State::Saving { key, .. } => self.record_unsaved(key, reason, out),
            state => {
                self.state = match halt_fault {
                    Some(fault) => State::Halted {
                        fault,
                        sequel: AfterHalt::State(Box::new(state)),
                    },
                    None => state,
                };
                return false;
            }
        }
        self.is_pause_due = false;
        self.state = State::Halted {
            fault: halt_fault.unwrap_or(false),
            sequel: AfterHalt::Trial,
        };
        true
    }

    fn record_unsaved(&mut self, key: TrialKey, reason: String, out: &mut StepActions) {
        (self.analysis_key, self.analysis) = (None, None);
        self.is_pause_due = false;
        let interruption = Interruption::NotSaved { reason };
        self.record(key, None, TrialOutcome::Interrupted { interruption }, out);
    }

    /// Returns the step after a recorded attempt: a break, a trial or the end.
    fn sequel_of(&self, settles: bool) -> AfterHalt {
        let since_s = self.now_s;
        if self.attempts.all_settled() {
            AfterHalt::State(Box::new(State::Finished { aborted: false }))
        } else if settles && self.attempts.rest_is_due(self.protocol.rest) {
            AfterHalt::State(Box::new(State::Rest { since_s }))
        } else {
            AfterHalt::Trial
        }
    }

    /// Begins the next trial, or ends the session after the last.
    pub(super) fn next_trial(&mut self, out: &mut StepActions) -> State {
        if self.attempts.all_settled() {
            return State::Finished { aborted: false };
        }
        self.enter_trial(out)
    }
}
