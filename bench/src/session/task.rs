//! The task that steps the protocol.
//!
//! The protocol's state machine decides; the task observes for it and carries out its actions. Two parts are state
//! machines of their own, each with a table of its states: the [attempt](live::attempt_state), with the data that each
//! state has, and the [last halt](super::last_halt).
//!
//! ```text
//! batches ─── acquired ─┬─ attempt ───┐
//! notices ─── recordings ─────────────┤
//! operator ── command queue, carrier ─┼─ observation ── protocol ── actions ─┬─ attempt, last halt
//! watch ───── last safety ────────────┘                                      ├─ drive, sound, recorder
//!                                                                            └─ display, log, outcome
//! ```
//!
//! | session | event | next |
//! | --- | --- | --- |
//! | runs | the protocol finishes | outcome known: the drive is disarmed |
//! | runs, unattended | a fault, a pause, or no consent | the bench ends |
//! | outcome known, unattended | the recorder has saved the last recording | the bench ends |
//! | any | the bench ends | an open recording is interrupted, and the report is sent |

use anyhow::Context;
use std::sync::Arc;
use std::time::Duration;

use config::Effective;
use devices::acquisition::RecordingCommand;
use devices::loudspeaker::Tone;
use devices::{BatchesDropped, Tuning};
use operator_ui::console::safety_event;
use protocols::{
    DriveRequest, Observation, OperatorCommand, Phase, SessionAction, SessionEvent,
    SessionEventKind, SessionOutcome, TrialEnd, TrialKey, Verdict,
};
use recording::manifest::EventKind;
use recording::writer::Ending;
use safety::{SafetyState, Trip};
use tasks::Task;
use tui::event::LogLevel::{Error, Warning};

use super::acquired::Acquired;
use super::at_a_glance::AtAGlance;
use super::command_queue::CommandQueue;
use super::end_state::EndState;
use super::last_halt::LastHalt;
use super::last_safety::LastSafety;
use super::operator_request::OperatorRequest;
use super::report::{SessionReport, summary_lines};
use super::saved::{self, Recordings};
use super::stop_kind::{cue_tone, interruption_kind, stop_kind};
use super::wiring::Wiring;
use journal::Entry;
use live::attempt_record::AttemptRecord;
use live::attempt_state::AttemptState;
use live::carrier_decision::CarrierEffect;
use live::due_trial::DueTrial;
use live::live_side::FitNews;
use live::{past_trials, screen_words};
use operator_ui::questions::Questions;

/// Task that steps the protocol.
pub struct SessionTask {
    machine: protocols::Session,
    /// The bench with its present carrier.
    bench: Arc<Effective>,
    wiring: Wiring,
    /// Whether the session runs without an operator to ask.
    unattended: bool,
    queue: CommandQueue,
    acquired: Acquired,
    attempt: AttemptState,
    recordings: Recordings,
    safety: LastSafety,
    halt: LastHalt,
    outcome: Option<SessionOutcome>,
    glance: AtAGlance,
}

impl SessionTask {
    /// Returns a session about to take its first step. `consent_by` is the operator who holds the signed consent, if
    /// there is one yet.
    pub fn new(
        machine: protocols::Session,
        bench: Arc<Effective>,
        mut wiring: Wiring,
        consent_by: Option<String>,
        questions: Questions,
        unattended: bool,
    ) -> Self {
        let mut queue = CommandQueue::new(questions);
        if let Some(question) = consent_by.and_then(|operator| queue.consent(operator)) {
            wiring.front.show(question);
        }
        Self {
            machine,
            bench,
            wiring,
            unattended,
            queue,
            acquired: Acquired::default(),
            attempt: AttemptState::default(),
            recordings: Recordings::default(),
            safety: LastSafety::default(),
            halt: LastHalt::default(),
            outcome: None,
            glance: AtAGlance::default(),
        }
    }

    fn take_batches(&mut self) {
        let mut dropped = None;
        while let Ok(mut batch) = self.wiring.batches.try_recv() {
            dropped = dropped.or_else(|| BatchesDropped::dropped_before(&batch));
            self.acquired.take(&batch);
            let position_m = batch.position.last().map(|row| row.position_m);
            self.wiring.displays.beat(batch.audio_s, position_m);
            self.wiring.live.take(&batch);
            for text in std::mem::take(&mut batch.warnings) {
                self.wiring.log(Warning, text);
            }
            if let Some(record) = self.attempt.record() {
                record.measurements.take(batch);
            }
        }
        if let Some(dropped) = dropped {
            self.fail(dropped.to_string());
        }
    }

    fn take_notices(&mut self) {
        let rate_hz = self.bench.config().audio.rate_hz;
        while let Ok(notice) = self.wiring.notices.try_recv() {
            let Some(end) = saved::ending(notice, self.acquired.audio_s, rate_hz) else {
                continue;
            };
            let news = self.recordings.end(&end);
            match end.outcome {
                Ok(entry) => self.wiring.journal.send(entry),
                Err(message) if news => self.fail(message),
                Err(message) => self.wiring.log(Warning, message),
            }
        }
        let overflow = self.recordings.overflow(&self.wiring.gauge);
        let log_loss = self.recordings.log_loss(&self.wiring.journal);
        for message in [overflow, log_loss].into_iter().flatten() {
            self.fail(message);
        }
    }

    fn take_fits(&mut self) {
        while let Some(FitNews { data, view }) = self.wiring.live.take_fit() {
            let t_s = self.acquired.audio_s;
            self.wiring.journal.send(Entry::Live { t_s, data });
            self.wiring.front.show(tui::Event::Fit(view));
        }
    }

    /// Stops the drive because its data cannot be kept.
    fn fail(&mut self, message: String) {
        self.wiring.log(Error, &message);
        self.wiring.drive.trip(Trip::Fault { message });
        self.safety.is_tripping = true;
    }

    fn take_requests(&mut self) -> anyhow::Result<()> {
        while let Some(action) = self.wiring.front.action() {
            let practices = self.machine.protocol().trials.practice;
            match OperatorRequest::from_action(action, practices) {
                OperatorRequest::Command(command) => {
                    if command == OperatorCommand::Resume {
                        self.wiring.reconnect_displays();
                    }
                    self.queue.push(command);
                }
                OperatorRequest::Consent => {
                    let operator = "operator at the dashboard".to_owned();
                    if let Some(question) = self.queue.consent(operator) {
                        self.wiring.front.show(question);
                    }
                }
                OperatorRequest::Reply(reply) => {
                    if let Some((question, person)) = self.queue.reply(reply) {
                        if let Some(person) = person {
                            self.wiring.journal.send(Entry::Person(person));
                        }
                        self.wiring.front.show(question);
                    }
                }
                OperatorRequest::Carrier(take) => {
                    let effects = self.wiring.carrier.answer(take);
                    self.apply(effects)?;
                }
                OperatorRequest::Stop => self.wiring.drive.trip(Trip::Operator),
                OperatorRequest::Rearm => {
                    self.wiring.drive.rearm();
                    if let Some(obstacle) = self.wiring.drive.rearm_obstacle() {
                        let text = obstacle.to_string();
                        self.wiring.log(Warning, &text);
                        self.wiring.front.show(tui::Event::Answer(text));
                    }
                }
                OperatorRequest::End => self.wiring.stop.raise(),
                OperatorRequest::Nothing => {}
            }
        }
        Ok(())
    }

    /// Changes the carrier of later trials once that is decided, while nothing is driven or recorded.
    fn change_carrier(&mut self) -> anyhow::Result<()> {
        let at_rest = self.attempt.record().is_none() && !self.wiring.drive.sounds();
        let now_s = self.acquired.audio_s;
        let effects = self.wiring.carrier.poll(&self.bench, at_rest, now_s);
        self.apply(effects)
    }

    /// Applies the effects of the decision on the carrier.
    fn apply(&mut self, effects: Vec<CarrierEffect>) -> anyhow::Result<()> {
        for effect in effects {
            match effect {
                CarrierEffect::Show(event) => self.wiring.front.show(*event),
                CarrierEffect::Record(data) => {
                    let t_s = self.acquired.audio_s;
                    self.wiring.journal.send(Entry::Live { t_s, data });
                }
                CarrierEffect::Change(by_hz, bench) => {
                    let carrier_hz = bench.config().plate.resonance_hz;
                    let tuning = Tuning::new(bench.config(), carrier_hz)?;
                    self.wiring.send(RecordingCommand::Retune(Box::new(tuning)));
                    self.wiring.carrier_hz.set(carrier_hz);
                    self.wiring.live.retune(by_hz);
                    self.bench = Arc::from(bench);
                }
            }
        }
        Ok(())
    }

    /// Shows the crops of completed explorations; analyses a completed trial once all of its data have arrived.
    fn analyse(&mut self) {
        let (now_s, context) = (
            self.acquired.audio_s,
            (self.machine.protocol(), &*self.bench),
        );
        if let Some(record) = self.attempt.record() {
            for crop in record.crops(now_s, context) {
                self.wiring.front.show(tui::Event::Crop(crop));
            }
        }
        let Some((record, due_trial)) = self.attempt.take_due(now_s) else {
            return;
        };
        self.wiring.send(RecordingCommand::End(Ending::Completed));
        let analysed = due_trial.analyse(record, context, &self.acquired.account);
        self.wiring.live.ask(analysed.request, analysed.attempt);
        self.attempt = AttemptState::Analysed(analysed.analysis);
    }

    fn step(&mut self) -> anyhow::Result<()> {
        let observation = self.observation();
        let before = self.machine.phase();
        let actions = self.machine.step(&observation);
        self.halt.step(before, self.machine.phase());
        let mut tone = None;
        for action in actions {
            self.carry_out(action, &mut tone)?;
        }
        Ok(())
    }

    fn observation(&mut self) -> Observation {
        let Acquired {
            audio_s, normal_n, ..
        } = self.acquired;
        let view = self.glance.view.as_ref();
        Observation {
            t_s: audio_s,
            normal_n,
            button_pressed: self.wiring.readiness.is_confirmed(audio_s, view, normal_n),
            command: self.queue.pop(self.machine.phase()),
            safety: self.safety.observed(),
            hold: self.wiring.signals.hold.get().map(screen_words::hold),
            drive_wait_s: self.wiring.drive_wait_s(),
            asking: self.wiring.carrier.is_open(),
            display_lost: self.wiring.displays.loss().map(str::to_owned),
            attended: !self.unattended,
            analysis: self.attempt.analysis().cloned(),
            recording: self.recordings.outcome(),
            recorder_lag_s: self.wiring.behind_s(),
        }
    }

    /// Carries out an action; `tone` is a cue of this step that its view has yet to go with.
    fn carry_out(&mut self, action: SessionAction, tone: &mut Option<Tone>) -> anyhow::Result<()> {
        let at_s = self.acquired.audio_s;
        match action {
            SessionAction::BeginTrial { key, drive, .. } => self.begin_trial(&key, &drive)?,
            SessionAction::Drive(DriveRequest::On(drive)) => {
                let program = (self.wiring.admit)(&drive, &self.bench)?;
                self.wiring.drive.start(program);
                self.wiring.mask(true);
            }
            SessionAction::Drive(DriveRequest::Off) => {
                self.wiring.drive.stop();
                self.wiring.mask(false);
            }
            SessionAction::Mark(interval) => self.wiring.send(RecordingCommand::Interval(interval)),
            SessionAction::EndTrial { end, .. } => self.end_trial(&end),
            SessionAction::AnalyseTrial { key, intervals } => self.attempt.complete(DueTrial {
                key,
                intervals,
                at_s,
            }),
            SessionAction::Verdict { key, verdict } => self.take_verdict(&key, &verdict)?,
            SessionAction::Cue(cue) => {
                let cue = cue_tone(cue);
                if let Some(sound) = &self.wiring.sound {
                    sound.play(cue);
                }
                *tone = Some(cue);
            }
            SessionAction::Log(event) => self.tell(event),
            SessionAction::Show(view) => {
                let cue = (tone.take(), at_s);
                self.glance.show(&mut self.wiring, &self.machine, view, cue);
            }
            SessionAction::Finished(outcome) => {
                let withdrawn = self.wiring.carrier.withdraw("the session ended");
                self.apply(withdrawn)?;
                self.wiring.drive.disarm();
                let summary = summary_lines(&self.machine.summary(), &self.acquired.account);
                self.wiring.front.show(tui::Event::Finished { summary });
                self.outcome = Some(outcome);
            }
        }
        Ok(())
    }

    fn begin_trial(&mut self, key: &TrialKey, drive: &protocols::Drive) -> anyhow::Result<()> {
        let withdrawn = self.wiring.carrier.withdraw("a trial began");
        self.apply(withdrawn)?;
        let begin = (self.wiring.begin)(key, drive, &self.bench)?;
        let carrier_hz = (begin.manifest.carrier_hz()).context("the trial has no carrier")?;
        self.wiring.live.modulate(drive.modulation_hz);
        self.recordings.begin(key.clone(), begin.folder.clone());
        self.wiring.send(RecordingCommand::Begin(Box::new(begin)));
        if let Some(text) = self.halt.take_event() {
            self.wiring.mark(EventKind::Resume, text);
        }
        if key.attempt > 1 {
            let text = format!("attempt {}", key.attempt);
            self.wiring.mark(EventKind::Redo, text);
        }
        self.glance.outlook.begin(self.acquired.audio_s);
        let (protocol, account) = (self.machine.protocol(), self.acquired.account);
        let record = AttemptRecord::new(key, protocol, carrier_hz, account);
        self.attempt = AttemptState::Recorded(record);
        Ok(())
    }

    fn end_trial(&mut self, end: &TrialEnd) {
        // The recording of a completed trial continues until its last data are in.
        if let TrialEnd::Interrupted { interruption } = end {
            self.attempt = AttemptState::Idle;
            self.glance.outlook.broken_off();
            let text = interruption.to_string();
            self.wiring.mark(interruption_kind(interruption), text);
            self.wiring.send(RecordingCommand::End(end.into()));
        }
    }

    fn take_verdict(&mut self, key: &TrialKey, verdict: &Verdict) -> anyhow::Result<()> {
        let now_s = self.acquired.audio_s;
        self.glance.outlook.judged(now_s);
        let analysis = self.attempt.take_analysis();
        let entry = screen_words::verdict(key, self.machine.protocol(), verdict, analysis.as_ref());
        self.wiring.front.show(tui::Event::Verdict(entry));
        if self.machine.trials_left() <= 1 && *verdict == Verdict::Accepted {
            return Ok(());
        }
        let drift_hz = self.wiring.live.drift_hz();
        let effects = self.wiring.carrier.judge(drift_hz, &self.bench, now_s);
        self.apply(effects)
    }

    fn tell(&mut self, event: SessionEvent) {
        if let Some(reason) = screen_words::automatic_pause(&event.kind) {
            self.wiring.log(Warning, &reason);
            self.halt = LastHalt::Paused(reason);
        }
        match &event.kind {
            SessionEventKind::SessionStarted {
                resumed_attempts: 1..,
                ..
            } => self.halt = LastHalt::Over("after the program's end"),
            SessionEventKind::TrialSettled { record } => {
                let protocol = self.machine.protocol();
                let (verdict, overruled) = (
                    past_trials::settled(record, protocol),
                    screen_words::overruled(record, protocol),
                );
                if verdict.interrupted || overruled.is_some() {
                    self.wiring.front.show(tui::Event::Verdict(verdict));
                }
                if let Some(text) = overruled {
                    self.wiring.log(Warning, text);
                }
                let not_saved = saved::not_saved(record);
                if let Some(reason) = not_saved.filter(|_| !self.safety.is_tripping) {
                    self.fail(reason);
                }
            }
            SessionEventKind::Marked { interval } => {
                if let Some(record) = self.attempt.record() {
                    record.mark(interval);
                }
            }
            SessionEventKind::SafetyTripped { reason } => {
                self.wiring.mark(stop_kind(&self.safety.state), reason);
            }
            _ => {}
        }
        if let Some((level, text)) = screen_words::notice(&event.kind) {
            self.wiring.log(level, text);
        }
        self.wiring.journal.send(Entry::Event(event));
    }

    fn watch_safety(&mut self) {
        let state = self.wiring.signals.state.get().unwrap_or_default();
        if let Some(before) = self.safety.renew(state) {
            self.alarm(&before);
            self.show_safety();
        }
        self.wiring.drive.poll(&self.safety.state);
    }

    /// Reports a stop that the protocol's state machine does not: a stop with a new reason, such as a plate that is alive
    /// after it, or a stop after the session's end.
    fn alarm(&mut self, before: &SafetyState) {
        let SafetyState::Tripped { trip } = &self.safety.state else {
            return;
        };
        if matches!(before, SafetyState::Tripped { .. }) || self.outcome.is_some() {
            let reason = trip.to_string();
            self.tell(SessionEvent {
                t_s: self.acquired.audio_s,
                kind: SessionEventKind::SafetyTripped { reason },
            });
        }
    }

    fn show_safety(&mut self) {
        let left = self.wiring.signals.dose.get();
        let sounds = self.wiring.drive.sounds();
        let event = safety_event(&self.safety.state, sounds, left.as_ref());
        self.wiring.front.show(event);
    }

    /// Ends an unattended session where an operator would be needed, and once its last recording is saved.
    fn end_unattended(&self) {
        let ends = match self.machine.phase() {
            _ if !self.unattended => false,
            _ if self.outcome.is_some() => !self.recordings.is_open(),
            _ if self.safety.is_tripping => false,
            Phase::Consent => self.queue.is_empty(),
            phase => matches!(phase, Phase::Fault | Phase::Paused),
        };
        if ends {
            self.wiring.stop.raise();
        }
    }
}

impl Task for SessionTask {
    fn name(&self) -> &'static str {
        "session"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        self.watch_safety();
        self.take_batches();
        self.take_notices();
        self.take_fits();
        self.wiring.look_at_displays();
        self.take_requests()?;
        self.change_carrier()?;
        self.analyse();
        self.step()?;
        let times = (self.bench.config().audio.rate_hz, now_ns);
        let (wiring, acquired) = (&mut self.wiring, &self.acquired);
        if self.glance.feed(wiring, &self.machine, acquired, times) {
            self.show_safety();
        }
        self.end_unattended();
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.wiring.drive.stop();
        // The last batches contain the count of the last losses.
        self.take_batches();
        self.take_notices();
        let (phase, observation) = (self.machine.phase(), self.observation());
        for action in self.machine.close(&observation) {
            self.carry_out(action, &mut None)?;
        }
        let end = EndState {
            paused: self.halt.pause(),
            attended: !self.unattended,
            failure: self.wiring.stop.failure(),
            safety: &self.safety.state,
            outcome: self.outcome.as_ref(),
            phase,
        };
        let (reason, status) = (end.reason(), end.status());
        if self.recordings.is_open() {
            let reason = reason.clone().unwrap_or_default();
            self.wiring
                .send(RecordingCommand::End(Ending::Interrupted { reason }));
        }
        self.wiring.journal.send(Entry::Stop {
            t_s: self.acquired.audio_s,
            status,
            reason: reason.clone(),
        });
        let _ = self.wiring.report.send(SessionReport {
            summary: self.machine.summary(),
            account: self.acquired.account,
            completed: matches!(self.outcome, Some(SessionOutcome::Completed { .. })),
            reason,
        });
        Ok(())
    }
}
