//! The state machine.

use std::collections::BTreeMap;

use super::event::{SessionEvent, SessionEventKind};
use super::interface::{
    Action, Cue, DriveRequest, Instruction, Observation, OperatorCommand, ParticipantView, Phase,
    Progress, Safety, SessionOutcome,
};
use crate::order;
use crate::participant::ParticipantId;
use crate::protocol::{Order, Protocol, Slider};
use crate::trial::{
    Direction, Interruption, Interval, IntervalKind, TrialEnd, TrialKey, TrialOutcome, TrialRecord,
};
use crate::verdict::{self, RedoReason, SessionSummary, TrialAnalysis, Verdict};

/// Why a session cannot begin or be resumed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// A counterbalanced order needs a participant number.
    #[error(
        "participant `{participant}` has no number, which a counterbalanced order needs: end the identifier in digits, for example `sub-01`"
    )]
    NoParticipantNumber {
        /// The identifier.
        participant: ParticipantId,
    },
    /// An attempt of the earlier part of the session is not one of this session.
    #[error(
        "trial {}, attempt {} ({}) of the earlier part does not belong to this protocol, participant and seed: {because}",
        .key.number, .key.attempt, .key.condition
    )]
    ForeignRecord {
        /// The attempt.
        key: TrialKey,
        /// What does not fit.
        because: &'static str,
    },
}

/// A participant's session: [`Session::step`] turns each observation into actions.
///
/// The drive is asked for only within a trial, and no trial begins before the consent is recorded. Interruptions
/// (pause, safety, a finger that does not come or go) repeat the trial without limit, since each needs the operator;
/// repetitions because of a verdict are limited by the protocol. A practice trial is judged but only the operator
/// repeats it.
#[derive(Clone, Debug)]
pub struct Session {
    protocol: Protocol,
    participant: ParticipantId,
    seed: u64,
    plan: Vec<Planned>,
    records: Vec<TrialRecord>,
    /// Last attempt not to be made, by trial number.
    left_out: BTreeMap<u32, u32>,
    resumed_attempts: usize,
    /// Index in `plan` of the trial that is next or runs.
    cursor: usize,
    now_s: f64,
    /// Whether the finger is on the plate; `None` when the force is not known.
    finger: Option<bool>,
    awaited: Option<TrialKey>,
    analysis: Option<TrialAnalysis>,
    started: bool,
    state: State,
}

#[derive(Clone, Debug)]
struct Planned {
    practice: bool,
    condition: usize,
}

/// A trial whose recording is open.
#[derive(Clone, Debug)]
struct Open {
    key: TrialKey,
    intervals: Vec<Interval>,
}

#[derive(Clone, Debug)]
enum State {
    Consent,
    Welcome,
    Trial {
        open: Open,
        step: TrialStep,
        since_s: f64,
    },
    Analysing {
        key: TrialKey,
        since_s: f64,
    },
    Judged {
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        reasons: Vec<RedoReason>,
        since_s: f64,
    },
    Rest {
        since_s: f64,
    },
    Halted {
        fault: bool,
        then: Then,
    },
    Finished {
        aborted: bool,
    },
}

/// Within a trial; explorations count from 0.
#[derive(Clone, Debug)]
enum TrialStep {
    /// `off_since_s`: since when the drive has been settled and the finger off.
    Baseline {
        off_since_s: Option<f64>,
    },
    Ready {
        exploration: usize,
    },
    Countdown {
        exploration: usize,
    },
    Exploration {
        exploration: usize,
        force: Mean,
    },
    Lift {
        exploration: usize,
        mean_n: Option<f64>,
    },
    Feedback {
        exploration: usize,
        mean_n: Option<f64>,
    },
}

/// What comes after a halt.
#[derive(Clone, Debug)]
enum Then {
    Trial,
    State(Box<State>),
}

#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    n: u32,
}

impl Mean {
    fn push(&mut self, x: f64) {
        self.sum += x;
        self.n += 1;
    }

    fn value(self) -> Option<f64> {
        (self.n > 0).then(|| self.sum / f64::from(self.n))
    }
}

impl Session {
    /// A new session. `seed` replaces the protocol's.
    ///
    /// # Errors
    /// [`SessionError::NoParticipantNumber`].
    pub fn new(
        protocol: Protocol,
        participant: ParticipantId,
        seed: u64,
    ) -> Result<Self, SessionError> {
        Self::resume(protocol, participant, seed, &[])
    }

    /// A session that goes on after `records` ([`records_from_events`](super::records_from_events)), with the same
    /// order. The consent is recorded anew.
    ///
    /// # Errors
    /// [`SessionError`].
    pub fn resume(
        protocol: Protocol,
        participant: ParticipantId,
        seed: u64,
        records: &[TrialRecord],
    ) -> Result<Self, SessionError> {
        let plan = plan(&protocol, &participant, seed)?;
        let mut session = Self {
            protocol,
            participant,
            seed,
            plan,
            records: Vec::new(),
            left_out: BTreeMap::new(),
            resumed_attempts: records.len(),
            cursor: 0,
            now_s: 0.0,
            finger: None,
            awaited: None,
            analysis: None,
            started: false,
            state: State::Consent,
        };
        for record in records {
            session.take_over(record)?;
        }
        Ok(session)
    }

    fn take_over(&mut self, record: &TrialRecord) -> Result<(), SessionError> {
        let foreign = |because| {
            Err(SessionError::ForeignRecord {
                key: record.key.clone(),
                because,
            })
        };
        if self.cursor == self.plan.len() {
            return foreign("all trials were settled before it");
        }
        let expected = self.next_key();
        if record.key.number != expected.number {
            return foreign("another trial was due");
        }
        if record.key.condition != expected.condition || record.key.practice != expected.practice {
            return foreign("the trial has another condition here");
        }
        if record.key.attempt < expected.attempt {
            return foreign("the attempt occurs twice");
        }
        self.records.push(record.clone());
        self.cursor += usize::from(record.outcome.settles());
        Ok(())
    }

    /// Makes no attempt up to `attempt` at trial `number`: a recording of it exists, whether or not the log tells of it.
    pub fn leave_out(&mut self, number: u32, attempt: u32) {
        let last = self.left_out.entry(number).or_default();
        *last = attempt.max(*last);
    }

    /// Takes an observation in and says what to do.
    pub fn step(&mut self, observation: &Observation) -> Vec<Action> {
        let mut out = Out {
            actions: Vec::new(),
            t_s: self.observe(observation),
        };
        let phase = self.phase();
        if !self.started {
            self.started = true;
            out.log(self.start_event());
            out.log(SessionEventKind::Phase { phase });
        }
        let tripped = self.safety(observation, &mut out);
        let obeyed = self.command(observation, &mut out);
        if !tripped && !obeyed {
            self.advance(observation, &mut out);
        }
        if self.phase() != phase {
            out.log(SessionEventKind::Phase {
                phase: self.phase(),
            });
        }
        if let State::Finished { aborted } = self.state
            && !matches!(phase, Phase::Finished | Phase::Aborted)
        {
            self.finish(aborted, &mut out);
        }
        out.actions.push(Action::Show(self.view()));
        out.actions
    }

    /// Where the session stands.
    pub fn phase(&self) -> Phase {
        match &self.state {
            State::Consent => Phase::Consent,
            State::Welcome => Phase::Welcome,
            State::Trial { step, .. } => match step {
                TrialStep::Baseline { .. } => Phase::Baseline,
                TrialStep::Ready { .. } => Phase::Ready,
                TrialStep::Countdown { .. } => Phase::Countdown,
                TrialStep::Exploration { .. } => Phase::Exploration,
                TrialStep::Lift { .. } => Phase::Lift,
                TrialStep::Feedback { .. } => Phase::Feedback,
            },
            State::Analysing { .. } => Phase::Analysing,
            State::Judged { .. } => Phase::Verdict,
            State::Rest { .. } => Phase::Rest,
            State::Halted { fault: true, .. } => Phase::Fault,
            State::Halted { fault: false, .. } => Phase::Paused,
            State::Finished { aborted: false } => Phase::Finished,
            State::Finished { aborted: true } => Phase::Aborted,
        }
    }

    /// The attempts so far, those taken over included.
    pub fn records(&self) -> &[TrialRecord] {
        &self.records
    }

    /// The session in numbers so far.
    pub fn summary(&self) -> SessionSummary {
        let planned = self.protocol.planned_trials() - self.protocol.trials.practice;
        SessionSummary::new(planned, &self.records)
    }

    /// The protocol it follows.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    fn observe(&mut self, observation: &Observation) -> f64 {
        if observation.t_s.is_finite() && observation.t_s > self.now_s {
            self.now_s = observation.t_s;
        }
        let contact_n = self.protocol.force.contact_n;
        self.finger = match observation.normal_n {
            Some(normal_n) if normal_n >= contact_n => Some(true),
            Some(normal_n) if normal_n < 0.5 * contact_n => Some(false),
            Some(normal_n) if normal_n.is_finite() => self.finger,
            _ => None,
        };
        if let Some(analysis) = &observation.analysis
            && self.awaited.as_ref() == Some(&analysis.key)
        {
            self.awaited = None;
            self.analysis = Some(analysis.clone());
        }
        self.now_s
    }

    /// Halts on a tripped safety chain; `true` if that used the step up.
    fn safety(&mut self, observation: &Observation, out: &mut Out) -> bool {
        let Safety::Tripped(reason) = &observation.safety else {
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
        self.halt(
            true,
            Interruption::Safety {
                reason: reason.clone(),
            },
            out,
        );
        true
    }

    /// Obeys the operator; `true` if that used the step up.
    fn command(&mut self, observation: &Observation, out: &mut Out) -> bool {
        let Some(command) = &observation.command else {
            return false;
        };
        match self.obey(command, &observation.safety, out) {
            // The state that waits for it acts on it.
            Ok(()) => *command != OperatorCommand::Continue,
            Err(because) => {
                out.log(SessionEventKind::CommandRefused {
                    command: command.clone(),
                    because: because.to_owned(),
                });
                false
            }
        }
    }

    fn obey(
        &mut self,
        command: &OperatorCommand,
        safety: &Safety,
        out: &mut Out,
    ) -> Result<(), &'static str> {
        match command {
            OperatorCommand::ConsentGiven { by } => self.consent(by, out),
            OperatorCommand::Continue => match self.phase() {
                Phase::Ready if self.finger != Some(true) => Err("the finger is not on the plate"),
                Phase::Welcome | Phase::Ready | Phase::Rest => Ok(()),
                _ => Err("nothing waits for it"),
            },
            OperatorCommand::Pause => match self.state {
                State::Consent => Err("nothing has begun"),
                State::Halted { .. } => Err("it is paused already"),
                State::Finished { .. } => Err("the session is over"),
                _ => {
                    self.halt(false, Interruption::Paused, out);
                    Ok(())
                }
            },
            OperatorCommand::Resume => self.unhalt(safety, out),
            OperatorCommand::Redo => self.redo(out),
            OperatorCommand::AcceptAnyway => self.accept_anyway(out),
            OperatorCommand::Abort => self.abort(out),
        }
    }

    fn consent(&mut self, by: &str, out: &mut Out) -> Result<(), &'static str> {
        if !matches!(self.state, State::Consent) {
            return Err("the consent is not awaited now");
        }
        if by.trim().is_empty() {
            return Err("it must say who recorded the consent");
        }
        out.log(SessionEventKind::ConsentGiven { by: by.to_owned() });
        self.state = State::Welcome;
        Ok(())
    }

    fn halt(&mut self, fault: bool, interruption: Interruption, out: &mut Out) {
        if fault {
            out.actions.push(Action::Drive(DriveRequest::Off));
        }
        let then = match self.take_state() {
            State::Trial { open, .. } => {
                self.interrupt(open, interruption, out);
                Then::Trial
            }
            State::Halted { then, .. } => then,
            other => Then::State(Box::new(other)),
        };
        self.state = State::Halted { fault, then };
    }

    fn unhalt(&mut self, safety: &Safety, out: &mut Out) -> Result<(), &'static str> {
        let State::Halted { fault, then } = &self.state else {
            return Err("it is not paused");
        };
        if *fault && *safety != Safety::Ok {
            return Err("the safety chain is not armed again");
        }
        self.state = match then.clone() {
            Then::Trial => self.begin_trial(out),
            Then::State(state) => self.restarted(*state),
        };
        Ok(())
    }

    /// A state whose waiting begins anew; a break goes on while the session is paused.
    fn restarted(&self, mut state: State) -> State {
        if let State::Analysing { since_s, .. } | State::Judged { since_s, .. } = &mut state {
            *since_s = self.now_s;
        }
        state
    }

    fn redo(&mut self, out: &mut Out) -> Result<(), &'static str> {
        match &self.state {
            State::Trial { .. } => {}
            State::Judged { key, .. } if self.redo_left(key.number) => {}
            State::Judged { .. } => return Err("no repetition is left"),
            _ => return Err("there is no trial to repeat"),
        }
        self.state = match self.take_state() {
            State::Trial { open, .. } => {
                self.interrupt(open, Interruption::Redo, out);
                self.begin_trial(out)
            }
            State::Judged {
                key,
                analysis,
                reasons,
                ..
            } => self.settle(key, analysis, TrialOutcome::Redo { reasons }, out),
            other => other,
        };
        Ok(())
    }

    fn accept_anyway(&mut self, out: &mut Out) -> Result<(), &'static str> {
        match &self.state {
            State::Judged { reasons, .. } if reasons.is_empty() => {
                return Err("the trial is accepted already");
            }
            State::Judged { .. } => {}
            _ => return Err("no trial has just been judged"),
        }
        self.state = match self.take_state() {
            State::Judged {
                key,
                analysis,
                reasons,
                ..
            } => self.settle(key, analysis, TrialOutcome::AcceptedAnyway { reasons }, out),
            other => other,
        };
        Ok(())
    }

    fn abort(&mut self, out: &mut Out) -> Result<(), &'static str> {
        if matches!(self.state, State::Finished { .. }) {
            return Err("the session is over");
        }
        let state = match self.take_state() {
            State::Halted {
                then: Then::State(state),
                ..
            } => *state,
            other => other,
        };
        match state {
            State::Trial { open, .. } => self.interrupt(open, Interruption::Aborted, out),
            State::Analysing { key, .. } => {
                let interruption = Interruption::Aborted;
                self.record(key, None, TrialOutcome::Interrupted { interruption }, out);
            }
            State::Judged {
                key,
                analysis,
                reasons,
                ..
            } => {
                let outcome = self.outcome(&key, reasons);
                self.record(key, analysis, outcome, out);
            }
            _ => {}
        }
        self.state = State::Finished { aborted: true };
        Ok(())
    }

    /// Lets time, finger and button act.
    fn advance(&mut self, observation: &Observation, out: &mut Out) {
        let told = observation.command == Some(OperatorCommand::Continue);
        let go = told || observation.button_pressed;
        self.state = match self.take_state() {
            State::Welcome if go => self.next_trial(out),
            State::Trial {
                open,
                step,
                since_s,
            } => self.advance_trial(open, step, since_s, go, observation.normal_n, out),
            State::Analysing { key, since_s } => self.advance_analysis(key, since_s, out),
            State::Judged {
                key,
                analysis,
                reasons,
                since_s,
            } if self.elapsed_s(since_s) >= self.protocol.timing.verdict_s => {
                let outcome = self.outcome(&key, reasons);
                self.settle(key, analysis, outcome, out)
            }
            State::Rest { since_s } if told || (go && self.rest_left_s(since_s) <= 0.0) => {
                self.next_trial(out)
            }
            other => other,
        };
    }

    fn advance_trial(
        &mut self,
        mut open: Open,
        step: TrialStep,
        since_s: f64,
        go: bool,
        normal_n: Option<f64>,
        out: &mut Out,
    ) -> State {
        let timing = self.protocol.timing;
        let timeouts = self.protocol.timeouts;
        let elapsed_s = self.elapsed_s(since_s);
        let on = self.finger == Some(true);
        let off = self.finger == Some(false);
        let next = match step {
            TrialStep::Baseline { off_since_s } => {
                let settled_s = since_s + timing.settle_s;
                let off_since_s = off.then(|| off_since_s.unwrap_or(self.now_s.max(settled_s)));
                match off_since_s {
                    Some(start_s) if self.elapsed_s(start_s) >= timing.baseline_s => {
                        let end_s = start_s + timing.baseline_s;
                        self.mark(&mut open, IntervalKind::Unloaded, start_s, end_s, out);
                        TrialStep::Ready { exploration: 0 }
                    }
                    _ if elapsed_s
                        > timing.settle_s + timing.baseline_s + timeouts.lift_finger_s =>
                    {
                        return self.time_out(open, Interruption::FingerNotLifted, out);
                    }
                    _ => {
                        let step = TrialStep::Baseline { off_since_s };
                        return State::Trial {
                            open,
                            step,
                            since_s,
                        };
                    }
                }
            }
            TrialStep::Ready { exploration } if on && go => TrialStep::Countdown { exploration },
            TrialStep::Ready { .. } if elapsed_s > timeouts.place_finger_s => {
                return self.time_out(open, Interruption::FingerNotPlaced, out);
            }
            TrialStep::Countdown { exploration } if off => {
                out.log(SessionEventKind::FingerLiftedEarly);
                TrialStep::Ready { exploration }
            }
            TrialStep::Countdown { exploration } if elapsed_s >= timing.countdown_s => {
                self.cue(Cue::Start, out);
                TrialStep::Exploration {
                    exploration,
                    force: Mean::default(),
                }
            }
            TrialStep::Exploration {
                exploration,
                mut force,
            } => {
                if let (true, Some(normal_n)) = (on, normal_n) {
                    force.push(normal_n);
                }
                let duration_s = self.slider(exploration).duration_s();
                if elapsed_s < duration_s {
                    let step = TrialStep::Exploration { exploration, force };
                    return State::Trial {
                        open,
                        step,
                        since_s,
                    };
                }
                self.cue(Cue::End, out);
                let direction = self.direction(exploration);
                let kind = IntervalKind::Exploration { direction };
                self.mark(&mut open, kind, since_s, since_s + duration_s, out);
                TrialStep::Lift {
                    exploration,
                    mean_n: force.value(),
                }
            }
            TrialStep::Lift {
                exploration,
                mean_n,
            } if off => TrialStep::Feedback {
                exploration,
                mean_n,
            },
            TrialStep::Lift {
                exploration,
                mean_n,
            } if elapsed_s > timeouts.lift_finger_s => {
                out.log(SessionEventKind::FingerNotLifted);
                TrialStep::Feedback {
                    exploration,
                    mean_n,
                }
            }
            TrialStep::Feedback { exploration, .. } if elapsed_s >= timing.feedback_s => {
                if exploration + 1 == self.protocol.exploration.directions.len() {
                    return self.complete(open, out);
                }
                TrialStep::Ready {
                    exploration: exploration + 1,
                }
            }
            step => {
                return State::Trial {
                    open,
                    step,
                    since_s,
                };
            }
        };
        State::Trial {
            open,
            step: next,
            since_s: self.now_s,
        }
    }

    fn advance_analysis(&mut self, key: TrialKey, since_s: f64, out: &mut Out) -> State {
        let analysis = self.analysis.take();
        let verdict = match &analysis {
            Some(analysis) => verdict::judge(analysis, &self.protocol.verdict_rules()),
            None if self.elapsed_s(since_s) > self.protocol.timeouts.analysis_s => Verdict::Redo {
                reasons: vec![RedoReason::NotAnalysed],
            },
            None => return State::Analysing { key, since_s },
        };
        self.awaited = None;
        out.actions.push(Action::Verdict {
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

    fn next_trial(&mut self, out: &mut Out) -> State {
        if self.cursor == self.plan.len() {
            return State::Finished { aborted: false };
        }
        self.begin_trial(out)
    }

    fn begin_trial(&mut self, out: &mut Out) -> State {
        let key = self.next_key();
        let drive = self.protocol.conditions[self.plan[self.cursor].condition].drive;
        out.actions.push(Action::BeginTrial {
            key: key.clone(),
            drive,
            at_s: self.now_s,
        });
        out.log(SessionEventKind::TrialBegan { key: key.clone() });
        out.actions.push(Action::Drive(DriveRequest::On(drive)));
        State::Trial {
            open: Open {
                key,
                intervals: Vec::new(),
            },
            step: TrialStep::Baseline { off_since_s: None },
            since_s: self.now_s,
        }
    }

    fn end_trial(&self, key: &TrialKey, end: TrialEnd, out: &mut Out) {
        out.actions.push(Action::Drive(DriveRequest::Off));
        out.actions.push(Action::EndTrial {
            key: key.clone(),
            end,
            at_s: self.now_s,
        });
    }

    fn complete(&mut self, open: Open, out: &mut Out) -> State {
        self.end_trial(&open.key, TrialEnd::Completed, out);
        out.actions.push(Action::AnalyseTrial {
            key: open.key.clone(),
            intervals: open.intervals,
        });
        self.awaited = Some(open.key.clone());
        State::Analysing {
            key: open.key,
            since_s: self.now_s,
        }
    }

    fn interrupt(&mut self, open: Open, interruption: Interruption, out: &mut Out) {
        let end = TrialEnd::Interrupted {
            interruption: interruption.clone(),
        };
        self.end_trial(&open.key, end, out);
        self.record(
            open.key,
            None,
            TrialOutcome::Interrupted { interruption },
            out,
        );
    }

    fn time_out(&mut self, open: Open, interruption: Interruption, out: &mut Out) -> State {
        self.interrupt(open, interruption, out);
        State::Halted {
            fault: false,
            then: Then::Trial,
        }
    }

    fn settle(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut Out,
    ) -> State {
        let settles = outcome.settles();
        self.record(key, analysis, outcome, out);
        if settles {
            self.cursor += 1;
            if self.rest_is_due() {
                return State::Rest {
                    since_s: self.now_s,
                };
            }
        }
        self.next_trial(out)
    }

    fn record(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut Out,
    ) {
        let record = TrialRecord {
            key,
            outcome,
            analysis,
        };
        self.records.push(record.clone());
        out.log(SessionEventKind::TrialSettled { record });
    }

    /// What becomes of a judged attempt when the operator keeps silent.
    fn outcome(&self, key: &TrialKey, reasons: Vec<RedoReason>) -> TrialOutcome {
        if reasons.is_empty() {
            TrialOutcome::Accepted
        } else if key.practice {
            TrialOutcome::AcceptedAnyway { reasons }
        } else if self.redo_left(key.number) {
            TrialOutcome::Redo { reasons }
        } else {
            TrialOutcome::GivenUp { reasons }
        }
    }

    fn redo_left(&self, number: u32) -> bool {
        let redone = |of_trial: bool| {
            self.records
                .iter()
                .filter(|r| matches!(r.outcome, TrialOutcome::Redo { .. }))
                .filter(|r| !of_trial || r.key.number == number)
                .count()
        };
        let limits = self.protocol.redo;
        redone(true) < limits.max_per_trial as usize && redone(false) < limits.max_total as usize
    }

    fn rest_is_due(&self) -> bool {
        let practice = self.protocol.trials.practice as usize;
        let every = self.protocol.rest.every_trials as usize;
        every > 0
            && self.cursor > practice
            && self.cursor < self.plan.len()
            && (self.cursor - practice).is_multiple_of(every)
    }

    fn next_key(&self) -> TrialKey {
        let planned = &self.plan[self.cursor];
        let number = self.cursor as u32 + 1;
        let made = self
            .records
            .iter()
            .filter(|r| r.key.number == number)
            .map(|r| r.key.attempt);
        let last = made.chain(self.left_out.get(&number).copied());
        TrialKey {
            number,
            attempt: last.max().unwrap_or(0) + 1,
            practice: planned.practice,
            condition: self.protocol.conditions[planned.condition].name.clone(),
        }
    }

    fn mark(&self, open: &mut Open, kind: IntervalKind, start_s: f64, end_s: f64, out: &mut Out) {
        // `start + (now − start)` may round to just after now, where the recording ends.
        let interval = Interval {
            kind,
            start_s,
            end_s: end_s.min(self.now_s),
        };
        open.intervals.push(interval);
        out.actions.push(Action::Mark(interval));
        out.log(SessionEventKind::Marked { interval });
    }

    fn cue(&self, cue: Cue, out: &mut Out) {
        if self.protocol.exploration.cues {
            out.actions.push(Action::Cue(cue));
        }
    }

    fn finish(&self, aborted: bool, out: &mut Out) {
        let summary = self.summary();
        let outcome = if aborted {
            SessionOutcome::Aborted { summary }
        } else {
            SessionOutcome::Completed { summary }
        };
        out.log(SessionEventKind::SessionEnded {
            outcome: outcome.clone(),
        });
        out.actions.push(Action::Finished(outcome));
    }

    fn start_event(&self) -> SessionEventKind {
        let name = |p: &Planned| self.protocol.conditions[p.condition].name.clone();
        SessionEventKind::SessionStarted {
            participant: self.participant.clone(),
            protocol: self.protocol.name.clone(),
            seed: self.seed,
            order: self.plan.iter().map(name).collect(),
            resumed_attempts: self.resumed_attempts,
        }
    }

    fn view(&self) -> ParticipantView {
        let mut view = ParticipantView {
            instruction: Instruction::Wait,
            slider_m: None,
            direction: None,
            countdown_s: None,
            mean_force_n: None,
            force_band: self.protocol.force,
            button: false,
            progress: None,
        };
        match &self.state {
            State::Consent | State::Analysing { .. } | State::Judged { .. } => {}
            State::Welcome => {
                view.instruction = Instruction::Welcome;
                view.button = true;
            }
            State::Trial {
                open,
                step,
                since_s,
            } => self.view_trial(open, step, *since_s, &mut view),
            State::Rest { since_s } => {
                let left_s = self.rest_left_s(*since_s);
                view.instruction = Instruction::Rest;
                view.countdown_s = Some(left_s);
                view.button = left_s <= 0.0;
            }
            State::Halted { .. } => view.instruction = Instruction::Paused,
            State::Finished { .. } => view.instruction = Instruction::Finished,
        }
        view
    }

    fn view_trial(&self, open: &Open, step: &TrialStep, since_s: f64, view: &mut ParticipantView) {
        let elapsed_s = self.elapsed_s(since_s);
        let (instruction, exploration) = match step {
            TrialStep::Baseline { .. } if self.finger == Some(false) => (Instruction::Wait, None),
            TrialStep::Baseline { .. } => (Instruction::LiftFinger, None),
            TrialStep::Ready { exploration } => {
                view.button = self.finger == Some(true);
                view.slider_m = Some(self.slider(*exploration).from_m);
                (Instruction::PlaceFinger, Some(*exploration))
            }
            TrialStep::Countdown { exploration } => {
                view.slider_m = Some(self.slider(*exploration).from_m);
                view.countdown_s = Some(self.protocol.timing.countdown_s - elapsed_s);
                (Instruction::GetReady, Some(*exploration))
            }
            TrialStep::Exploration { exploration, .. } => {
                view.slider_m = Some(self.slider(*exploration).position_m(elapsed_s));
                (Instruction::FollowSlider, Some(*exploration))
            }
            TrialStep::Lift { exploration, .. } => (Instruction::LiftFinger, Some(*exploration)),
            TrialStep::Feedback {
                exploration,
                mean_n,
            } => {
                view.mean_force_n = *mean_n;
                (Instruction::Feedback, Some(*exploration))
            }
        };
        view.instruction = instruction;
        view.direction = view.slider_m.and(exploration).map(|e| self.direction(e));
        view.progress = Some(Progress {
            trial: open.key.number,
            trials: self.plan.len() as u32,
            exploration: exploration.map_or(0, |e| e as u32 + 1),
            explorations: self.protocol.exploration.directions.len() as u32,
            practice: open.key.practice,
            attempt: open.key.attempt,
        });
    }

    fn direction(&self, exploration: usize) -> Direction {
        self.protocol.exploration.directions[exploration]
    }

    fn slider(&self, exploration: usize) -> Slider {
        self.protocol
            .exploration
            .slider(self.direction(exploration))
    }

    fn elapsed_s(&self, since_s: f64) -> f64 {
        self.now_s - since_s
    }

    fn rest_left_s(&self, since_s: f64) -> f64 {
        (self.protocol.rest.min_s - self.elapsed_s(since_s)).max(0.0)
    }

    /// Takes the state out to change it; the caller puts the next one in.
    fn take_state(&mut self) -> State {
        std::mem::replace(&mut self.state, State::Consent)
    }
}

/// The actions of one step.
struct Out {
    actions: Vec<Action>,
    t_s: f64,
}

impl Out {
    fn log(&mut self, kind: SessionEventKind) {
        self.actions.push(Action::Log(SessionEvent {
            t_s: self.t_s,
            kind,
        }));
    }
}

fn plan(
    protocol: &Protocol,
    participant: &ParticipantId,
    seed: u64,
) -> Result<Vec<Planned>, SessionError> {
    let number = match (protocol.trials.order, participant.number()) {
        (Order::Counterbalanced, None) => {
            return Err(SessionError::NoParticipantNumber {
                participant: participant.clone(),
            });
        }
        (_, number) => number.unwrap_or(0),
    };
    let conditions = protocol.conditions.len();
    let order = order::conditions(
        protocol.trials.order,
        conditions,
        protocol.trials.per_condition,
        number,
        seed,
        order::stream(participant.as_str()),
    );
    let practice = (0..protocol.trials.practice as usize).map(|i| (true, i % conditions));
    let main = order.into_iter().map(|condition| (false, condition));
    Ok(practice
        .chain(main)
        .map(|(practice, condition)| Planned {
            practice,
            condition,
        })
        .collect())
}
