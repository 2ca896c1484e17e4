//! Commands of the operator, safety trips and loss of the participant's display.

use super::action::{DriveRequest, SessionAction, StepActions};
use super::event::SessionEventKind;
use super::machine::Session;
use super::observation::{DeadManAction, Observation, OperatorCommand, SafetyChain};
use super::phase::Phase;
use super::state::{AfterHalt, State};
use crate::analysis::TrialAnalysis;
use crate::record::TrialOutcome;
use crate::redo_reason::RedoReason;
use crate::trial::{Interruption, TrialKey};

/// Why a command of the operator is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refusal {
    #[error("consent is not awaited")]
    ConsentNotAwaited,
    #[error("name who recorded the consent")]
    ConsentByNobody,
    #[error("the finger is not on the plate")]
    NoFinger,
    #[error("the session is not waiting to continue")]
    NotWaiting,
    #[error("the session has not begun")]
    NotBegun,
    #[error("the session is already paused")]
    AlreadyPaused,
    #[error("the session is not paused")]
    NotPaused,
    #[error("that attempt has ended: press the key again")]
    OtherAttempt,
    #[error("the participant's display is lost: bring it back, then resume")]
    DisplayLost,
    #[error("the safety chain is not armed again")]
    NotArmed,
    #[error("the hour's driving time is used up")]
    DrivingTimeSpent,
    #[error("no repetition is left")]
    NoRepetitionLeft,
    #[error("no trial is running, and no verdict is open")]
    NoTrial,
    #[error("the trial is already accepted")]
    AlreadyAccepted,
    #[error("no trial has just been judged")]
    NotJudged,
    #[error("the session is over")]
    Over,
}

impl Session {
    /// Halts on a tripped safety chain; returns whether that completed the step.
    pub(super) fn safety(&mut self, observation: &Observation, out: &mut StepActions) -> bool {
        let SafetyChain::Tripped(reason) = &observation.safety else {
            return false;
        };
        if matches!(
            self.state,
            State::Finished { .. } | State::Halted { fault: true, .. }
        ) {
            return false;
        }
        out.log(SessionEventKind::SafetyTripped {
            reason: reason.clone(),
        });
        self.let_go = self.hold == Some(DeadManAction::Press);
        self.halt(
            true,
            Interruption::Safety {
                reason: reason.clone(),
            },
            out,
        );
        true
    }

    /// Pauses when the participant's display is lost; returns whether that completed the step.
    pub(super) fn display(&mut self, observation: &Observation, out: &mut StepActions) -> bool {
        let previous = std::mem::replace(&mut self.display_lost, observation.display_lost.clone());
        let reason = match (previous, &self.display_lost) {
            (None, Some(reason)) => reason.clone(),
            (Some(_), None) => {
                out.log(SessionEventKind::DisplayBack);
                return false;
            }
            _ => return false,
        };
        out.log(SessionEventKind::DisplayLost {
            reason: reason.clone(),
        });
        if matches!(self.state, State::Finished { .. } | State::Halted { .. }) {
            return false;
        }
        self.halt(false, Interruption::DisplayLost { reason }, out);
        true
    }

    /// Executes the operator's command; returns whether that completed the step.
    pub(super) fn command(&mut self, observation: &Observation, out: &mut StepActions) -> bool {
        let Some(command) = &observation.command else {
            return false;
        };
        match self.execute(command, &observation.safety, out) {
            // The state that awaits the command acts on it.
            Ok(()) => *command != OperatorCommand::Continue,
            Err(because) => {
                out.log(SessionEventKind::CommandRefused {
                    command: command.clone(),
                    because: because.to_string(),
                });
                false
            }
        }
    }

    fn execute(
        &mut self,
        command: &OperatorCommand,
        safety: &SafetyChain,
        out: &mut StepActions,
    ) -> Result<(), Refusal> {
        match command {
            OperatorCommand::ConsentGiven { by } => self.consent(by, out),
            OperatorCommand::Continue => match self.phase() {
                Phase::Ready if self.finger != Some(true) => Err(Refusal::NoFinger),
                Phase::Verdict if self.is_asking => Err(Refusal::NotWaiting),
                Phase::Welcome | Phase::Ready | Phase::Rest | Phase::Verdict => Ok(()),
                _ => Err(Refusal::NotWaiting),
            },
            OperatorCommand::Pause => self.pause(out),
            OperatorCommand::PauseNow { number, attempt } => {
                self.require_current(*number, *attempt)?;
                self.pause_now(out)
            }
            OperatorCommand::Resume => self.leave_halt(safety, out),
            OperatorCommand::Redo { number, attempt } => {
                self.require_current(*number, *attempt)?;
                self.redo(out)
            }
            OperatorCommand::AcceptAnyway { number, attempt } => {
                self.require_current(*number, *attempt)?;
                self.accept_anyway(out)
            }
            OperatorCommand::Abort => self.abort(out),
        }
    }

    /// Requires that a command names the current attempt, so that it never applies to the next one.
    fn require_current(&self, number: u32, attempt: u32) -> Result<(), Refusal> {
        match self.state.current() {
            Some(key) if (key.number, key.attempt) == (number, attempt) => Ok(()),
            Some(_) => Err(Refusal::OtherAttempt),
            None => Err(Refusal::NoTrial),
        }
    }

    fn pause(&mut self, out: &mut StepActions) -> Result<(), Refusal> {
        if let State::Trial { open, .. } = &self.state {
            if !std::mem::replace(&mut self.is_pause_due, true) {
                let key = open.key.clone();
                out.log(SessionEventKind::PauseAwaited { key });
            }
            return Ok(());
        }
        self.pause_now(out)
    }

    fn pause_now(&mut self, out: &mut StepActions) -> Result<(), Refusal> {
        match self.state {
            State::Consent => Err(Refusal::NotBegun),
            State::Halted { .. } => Err(Refusal::AlreadyPaused),
            State::Finished { .. } => Err(Refusal::Over),
            _ => {
                self.halt(false, Interruption::Paused, out);
                Ok(())
            }
        }
    }

    fn consent(&mut self, name: &str, out: &mut StepActions) -> Result<(), Refusal> {
        if !matches!(self.state, State::Consent) {
            return Err(Refusal::ConsentNotAwaited);
        }
        if name.trim().is_empty() {
            return Err(Refusal::ConsentByNobody);
        }
        out.log(SessionEventKind::ConsentGiven {
            by: name.to_owned(),
        });
        self.state = State::Welcome;
        Ok(())
    }

    fn halt(&mut self, fault: bool, interruption: Interruption, out: &mut StepActions) {
        self.is_pause_due = false;
        if fault {
            out.push(SessionAction::Drive(DriveRequest::Off));
        }
        let sequel = match self.take_state() {
            State::Trial { open, .. } => {
                self.interrupt(open, interruption, out);
                AfterHalt::Trial
            }
            State::Hold { .. } | State::Behind { .. } => AfterHalt::Trial,
            State::Halted { sequel, .. } => sequel,
            state => AfterHalt::State(Box::new(state)),
        };
        self.state = State::Halted { fault, sequel };
    }

    fn leave_halt(&mut self, safety: &SafetyChain, out: &mut StepActions) -> Result<(), Refusal> {
        if std::mem::take(&mut self.is_pause_due) {
            return Ok(());
        }
        let State::Halted { fault, sequel } = &self.state else {
            return Err(Refusal::NotPaused);
        };
        if self.display_lost.is_some() {
            return Err(Refusal::DisplayLost);
        }
        if *fault && *safety != SafetyChain::Ok {
            return Err(Refusal::NotArmed);
        }
        if matches!(sequel, AfterHalt::Trial) && self.drive_wait_s > 0.0 {
            return Err(Refusal::DrivingTimeSpent);
        }
        self.state = match sequel.clone() {
            AfterHalt::Trial => self.enter_trial(out),
            AfterHalt::State(state) => self.restart_timeout(*state),
        };
        Ok(())
    }

    /// Returns a halted state with its timeout restarted. Pauses prolong neither a break nor the recorder's time to save.
    fn restart_timeout(&self, mut state: State) -> State {
        if let State::Analysing { since_s, .. } | State::Judged { since_s, .. } = &mut state {
            *since_s = self.now_s;
        }
        state
    }

    fn redo(&mut self, out: &mut StepActions) -> Result<(), Refusal> {
        if let Some(key) = self.state.judged_key() {
            if !self.attempts.redo_left(key.number, self.protocol.redo) {
                return Err(Refusal::NoRepetitionLeft);
            }
            self.overrule(|reasons| TrialOutcome::Redo { reasons }, out);
            return Ok(());
        }
        if !matches!(self.state, State::Trial { .. }) {
            return Err(Refusal::NoTrial);
        }
        self.state = match self.take_state() {
            State::Trial { open, .. } => {
                self.interrupt(open, Interruption::Redo, out);
                if std::mem::take(&mut self.is_pause_due) {
                    self.paused_before_trial()
                } else {
                    self.enter_trial(out)
                }
            }
            state => state,
        };
        Ok(())
    }

    fn accept_anyway(&mut self, out: &mut StepActions) -> Result<(), Refusal> {
        match self.state.reasons() {
            None => return Err(Refusal::NotJudged),
            Some([]) => return Err(Refusal::AlreadyAccepted),
            Some(_) => {}
        }
        self.overrule(|reasons| TrialOutcome::AcceptedAnyway { reasons }, out);
        Ok(())
    }

    /// Settles the judged attempt as the operator decides; a halted session stays halted.
    fn overrule(
        &mut self,
        outcome: impl FnOnce(Vec<RedoReason>) -> TrialOutcome,
        out: &mut StepActions,
    ) {
        self.state = match self.take_state() {
            State::Judged {
                key,
                analysis,
                reasons,
                ..
            } => self.settle(key, analysis, outcome(reasons), out),
            State::Halted {
                fault,
                sequel: AfterHalt::State(state),
            } => {
                let sequel = match *state {
                    State::Judged {
                        key,
                        analysis,
                        reasons,
                        ..
                    } => self.settle_halted(key, analysis, outcome(reasons), out),
                    state => AfterHalt::State(Box::new(state)),
                };
                State::Halted { fault, sequel }
            }
            state => state,
        };
    }

    fn abort(&mut self, out: &mut StepActions) -> Result<(), Refusal> {
        if matches!(self.state, State::Finished { .. }) {
            return Err(Refusal::Over);
        }
        let interruption = Interruption::Aborted;
        match (self.judged(), self.state.running().clone()) {
            (Some((key, _, outcome)), _) if self.awaits_save(&outcome) => {
                self.record(key, None, TrialOutcome::Interrupted { interruption }, out);
            }
            (Some((key, analysis, outcome)), _) => self.record(key, analysis, outcome, out),
            (None, State::Trial { open, .. }) => self.interrupt(open, interruption, out),
            (None, State::Analysing { key, .. }) => {
                self.record(key, None, TrialOutcome::Interrupted { interruption }, out);
            }
            (None, _) => {}
        }
        self.state = State::Finished { aborted: true };
        Ok(())
    }

    /// Ends a session that its program leaves before its end: an attempt that was judged and saved counts, as at an abort. If it was the
    /// last one, the session is complete.
    pub fn close(&mut self, observation: &Observation) -> Vec<SessionAction> {
        let mut out = StepActions::at(self.observe(observation));
        let saved = self
            .judged()
            .filter(|(_, _, outcome)| !self.awaits_save(outcome));
        let Some((key, analysis, outcome)) = saved else {
            return Vec::new();
        };
        self.record(key, analysis, outcome, &mut out);
        let is_complete = self.attempts.all_settled();
        self.state = State::Finished {
            aborted: !is_complete,
        };
        if is_complete {
            self.finish(false, &mut out);
        }
        out.actions
    }

    /// Returns the attempt that is judged or saved, also of a halted session, with its outcome if it counts now.
    fn judged(&self) -> Option<(TrialKey, Option<TrialAnalysis>, TrialOutcome)> {
        match self.state.running().clone() {
            State::Judged {
                key,
                analysis,
                reasons,
                ..
            } => {
                let outcome = self.outcome(&key, reasons);
                Some((key, analysis, outcome))
            }
            State::Saving {
                key,
                analysis,
                outcome,
                ..
            } => Some((key, analysis, outcome)),
            _ => None,
        }
    }
}
