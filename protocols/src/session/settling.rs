//! From a recorded trial to the next: analysis, verdict, break.

use super::action::{Action, StepActions};
use super::machine::Session;
use super::state::{AfterHalt, State};
use crate::analysis::TrialAnalysis;
use crate::record::TrialOutcome;
use crate::redo_reason::RedoReason;
use crate::trial::TrialKey;
use crate::verdict::{Verdict, judge};

impl Session {
    /// Judges the attempt once its analysis arrived or timed out.
    pub(super) fn advance_analysis(
        &mut self,
        key: TrialKey,
        since_s: f64,
        out: &mut StepActions,
    ) -> State {
        let analysis = self.analysis.take();
        let verdict = match &analysis {
            Some(analysis) => judge(analysis, &self.protocol.verdict_rules()),
            None if self.elapsed_s(since_s) > self.protocol.timeouts.analysis_s => Verdict::Redo {
                reasons: vec![RedoReason::NotAnalysed],
            },
            None => return State::Analysing { key, since_s },
        };
        self.awaited = None;
        out.push(Action::Verdict {
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

    /// Returns the outcome of a judged attempt that the operator does not overrule.
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

    /// Records an attempt and begins what follows: a break, a trial or the end.
    pub(super) fn settle(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut StepActions,
    ) -> State {
        let settles = outcome.settles();
        self.record(key, analysis, outcome, out);
        if std::mem::take(&mut self.pausing) && !self.attempts.all_settled() {
            return State::Halted {
                fault: false,
                then: self.after_settled(settles),
            };
        }
        match self.after_settled(settles) {
            AfterHalt::Trial => self.next_trial(out),
            AfterHalt::State(state) => *state,
        }
    }

    /// Records an attempt that was judged and overruled while the session is halted; returns what follows the halt.
    pub(super) fn settle_halted(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut StepActions,
    ) -> AfterHalt {
        let settles = outcome.settles();
        self.record(key, analysis, outcome, out);
        self.after_settled(settles)
    }

    /// Returns what follows an attempt that has been recorded: a break, a trial or the end.
    fn after_settled(&self, settles: bool) -> AfterHalt {
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
