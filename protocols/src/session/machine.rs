//! The state of a session.

use super::attempts::Attempts;
use super::error::SessionError;
use super::observation::{DeadManAction, RecordingOutcome};
use super::phase::Phase;
use super::plan;
use super::state::State;
use crate::analysis::TrialAnalysis;
use crate::protocol::{Protocol, Slider};
use crate::record::TrialRecord;
use crate::redo_reason::RedoReason;
use crate::summary::SessionSummary;
use crate::trial::{Direction, Interruption, TrialKey};
use participants::ParticipantId;

/// Minimum time for an operator to overrule an accepting verdict, s.
const OVERRULE_ACCEPTED_S: f64 = 2.0;
/// Minimum time for an operator to overrule a rejecting verdict, which includes reading its reasons, s.
const OVERRULE_REJECTED_S: f64 = 6.0;

/// A participant's session: [`Session::step`] turns each observation into actions.
///
/// The drive is requested only within a trial, and no trial begins before the consent is recorded. A trial is accepted
/// only when its recording is saved. Interruptions (pause, safety, timeouts, recordings that are not saved) repeat the
/// trial without limit, since each needs the operator; repetitions because of a verdict are limited by the protocol. A
/// practice trial is judged, but only the operator repeats it.
///
/// ```
/// use protocols::{Observation, OperatorCommand, Phase, Protocol, Session, built_in};
///
/// let text = built_in("demo").expect("a built-in protocol");
/// let protocol = Protocol::parse(text, "demo.toml")?;
/// let mut session = Session::new(protocol, "sub-01".parse()?, 2021)?;
/// session.step(&Observation { t_s: 0.0, ..Observation::default() });
/// assert_eq!(session.phase(), Phase::Consent);
/// session.step(&Observation {
///     t_s: 0.1,
///     command: Some(OperatorCommand::ConsentGiven { by: "N. H.".to_owned() }),
///     ..Observation::default()
/// });
/// assert_eq!(session.phase(), Phase::Welcome);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Session {
    pub(super) protocol: Protocol,
    pub(super) participant: ParticipantId,
    pub(super) seed: u64,
    pub(super) attempts: Attempts,
    /// Number of attempts restored from an earlier part of the session.
    pub(super) resumed_attempts: usize,
    /// Time of the last observation, s.
    pub(super) now_s: f64,
    /// Whether the finger is on the plate; `None` if the force is not known.
    pub(super) finger: Option<bool>,
    /// The dead-man switch; `None` on a bench without one.
    pub(super) hold: Option<DeadManAction>,
    /// Whether the safety chain tripped while the dead-man switch was open.
    pub(super) let_go: bool,
    /// Why the participant cannot see the screen.
    pub(super) display_lost: Option<String>,
    /// Whether an operator watches.
    pub(super) is_attended: bool,
    /// Whether the operator must answer a question before the next trial.
    pub(super) is_asking: bool,
    /// Whether the session pauses at the end of the attempt.
    pub(super) is_pause_due: bool,
    /// Time after which the hour's driving time allows another trial, s.
    pub(super) drive_wait_s: f64,
    /// Attempt with an analysis under way.
    pub(super) analysis_key: Option<TrialKey>,
    /// Its analysis, after it has arrived.
    pub(super) analysis: Option<TrialAnalysis>,
    /// Outcome of the current attempt's recording, if known.
    pub(super) recording_outcome: Option<RecordingOutcome>,
    /// Audio that is not on the disk yet, or time since the recorder last answered, s.
    pub(super) recorder_lag_s: f64,
    /// Whether the first step was made.
    pub(super) has_started: bool,
    pub(super) state: State,
}

impl Session {
    /// Begins a session. `seed` replaces the protocol's.
    ///
    /// # Errors
    /// [`SessionError::NoParticipantNumber`] for a counterbalanced order.
    pub fn new(
        protocol: Protocol,
        participant: ParticipantId,
        seed: u64,
    ) -> Result<Self, SessionError> {
        Self::resume(protocol, participant, seed, &[])
    }

    /// Resumes a session after `records` ([`records_from_events`](crate::records_from_events)), in the same order. The
    /// consent must be recorded again.
    ///
    /// # Errors
    /// [`SessionError::ForeignRecord`] if `records` do not belong to this protocol, participant and seed;
    /// [`SessionError::NoParticipantNumber`] for a counterbalanced order.
    pub fn resume(
        protocol: Protocol,
        participant: ParticipantId,
        seed: u64,
        records: &[TrialRecord],
    ) -> Result<Self, SessionError> {
        let mut attempts = Attempts::new(plan::plan(&protocol, &participant, seed)?);
        for record in records {
            attempts.restore(record)?;
        }
        Ok(Self {
            protocol,
            participant,
            seed,
            resumed_attempts: attempts.records().len(),
            attempts,
            now_s: 0.0,
            finger: None,
            hold: None,
            let_go: false,
            display_lost: None,
            is_attended: false,
            is_asking: false,
            is_pause_due: false,
            drive_wait_s: 0.0,
            analysis_key: None,
            analysis: None,
            recording_outcome: None,
            recorder_lag_s: 0.0,
            has_started: false,
            state: State::Consent,
        })
    }

    /// Skips the attempts up to `attempt` at trial `number`, because recordings of them exist, even if the event log
    /// does not contain them.
    pub fn leave_out(&mut self, number: u32, attempt: u32) {
        self.attempts.leave_out(number, attempt);
    }

    /// Withdraws the outcome of an attempt of an earlier part because its recording is lost: the attempt counts as
    /// interrupted and the trial is repeated. Returns the attempt for the event log, where a later part of the session
    /// reads it; `None` if no such attempt settled its trial.
    pub fn withdraw(&mut self, number: u32, attempt: u32, reason: String) -> Option<TrialRecord> {
        let mut records = self.records().iter();
        let record =
            records.find(|record| (record.key.number, record.key.attempt) == (number, attempt))?;
        let key = record.key.clone();
        self.attempts
            .withdraw(&key, &Interruption::NotSaved { reason })
    }

    /// Returns the session's phase.
    pub fn phase(&self) -> Phase {
        self.state.phase()
    }

    /// Returns the attempt that runs, is analysed, can be overruled or is saved, also during a pause.
    pub fn current(&self) -> Option<&TrialKey> {
        self.state.current()
    }

    /// Whether the operator can overrule the verdict on [`current`](Self::current).
    pub fn is_judged(&self) -> bool {
        self.state.judged_key().is_some()
    }

    /// Returns the time until the verdict stands, s; `None` without a verdict, and if only the operator can end the wait.
    pub fn verdict_left_s(&self) -> Option<f64> {
        match &self.state {
            State::Judged {
                reasons, since_s, ..
            } if !self.is_asking => {
                Some((self.verdict_s(reasons) - self.elapsed_s(*since_s)).max(0.0))
            }
            _ => None,
        }
    }

    /// Whether attempts of an earlier part of the session were restored.
    pub fn is_resumed(&self) -> bool {
        self.resumed_attempts > 0
    }

    /// Whether a pause waits for the end of the attempt.
    pub fn is_pausing(&self) -> bool {
        self.is_pause_due
    }

    /// Returns the number of trials that are not settled yet, practice included.
    pub fn trials_left(&self) -> u32 {
        self.attempts.trials_left()
    }

    /// Returns the number of the trial that is next, running or judged, and of the one after it, from 1 with practice;
    /// past the end, the number after the last trial.
    pub fn next_numbers(&self) -> (u32, u32) {
        self.attempts.next_numbers()
    }

    /// Returns the number of repetitions by verdicts left for the trial that is next, running or judged, and for all
    /// trials together, as far as the trials left can use them.
    pub fn repetitions_left(&self) -> (u32, u32) {
        let (number, _) = self.next_numbers();
        let limits = self.protocol.redo;
        let (of_trial, in_session) = self.attempts.redos_left(number, limits);
        (of_trial, in_session.min(self.attempts.usable_redos(limits)))
    }

    /// Returns whether the open verdict repeats its trial unless it is overruled.
    pub fn verdict_repeats(&self) -> bool {
        let verdict = self.state.current().zip(self.state.reasons());
        verdict.is_some_and(|(key, reasons)| !self.outcome(key, reasons.to_vec()).settles())
    }

    /// Returns the attempts so far, restored ones included.
    pub fn records(&self) -> &[TrialRecord] {
        self.attempts.records()
    }

    /// Returns counts and means over the attempts so far.
    pub fn summary(&self) -> SessionSummary {
        let main_trials = self.protocol.planned_trials() - self.protocol.trials.practice;
        SessionSummary::new(main_trials, self.records())
    }

    /// Returns the protocol of the session.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Returns the direction of an exploration, numbered from 0.
    pub(super) fn direction(&self, exploration: usize) -> Direction {
        self.protocol.exploration.directions[exploration]
    }

    /// Returns the slider of an exploration, numbered from 0.
    pub(super) fn slider(&self, exploration: usize) -> Slider {
        self.protocol
            .exploration
            .slider(self.direction(exploration))
    }

    /// Returns the time since `since_s`, s.
    pub(super) fn elapsed_s(&self, since_s: f64) -> f64 {
        self.now_s - since_s
    }

    /// Returns the time until the button ends a break that began at `since_s`, s.
    pub(super) fn rest_left_s(&self, since_s: f64) -> f64 {
        (self.protocol.rest.min_s - self.elapsed_s(since_s)).max(0.0)
    }

    /// Returns the time in which a verdict can be overruled, s: with an operator, long enough to read it and press a key.
    pub(super) fn verdict_s(&self, reasons: &[RedoReason]) -> f64 {
        let shortest_s = match (self.is_attended, reasons.is_empty()) {
            (false, _) => 0.0,
            (true, true) => OVERRULE_ACCEPTED_S,
            (true, false) => OVERRULE_REJECTED_S,
        };
        self.protocol.timing.verdict_s.max(shortest_s)
    }

    /// Takes the state out to change it; the caller puts the next one in.
    pub(super) fn take_state(&mut self) -> State {
        std::mem::replace(&mut self.state, State::Consent)
    }
}
