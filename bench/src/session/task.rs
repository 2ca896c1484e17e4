//! The task that steps the protocol.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use analysis::measurements::Measurements;
use config::Effective;
use crossbeam_channel::Sender;
use devices::acquisition::RecordingCommand;
use devices::loudspeaker::Tone;
use devices::{BatchesDropped, Tuning};
use operator_ui::console::safety_event;
use protocols::{
    Action, DriveRequest, Observation, OperatorCommand, ParticipantView, Phase, SessionEvent,
    SessionEventKind, SessionOutcome, TrialAnalysis, TrialEnd, TrialKey, Verdict,
};
use recording::manifest::EventKind;
use recording::pipeline::Account;
use recording::writer::Ending;
use safety::{SafetyState, Trip};
use tasks::Task;
use tui::event::LogLevel;

use super::at_a_glance::AtAGlance;
use super::consent::{AnswerEffects, Consent};
use super::due_trial::{DATA_DELAY_S, DueTrial};
use super::end_state::{EndState, pause};
use super::operator_request::OperatorRequest;
use super::questions::Questions;
use super::report::{Report, summary_lines};
use super::saved::{self, Recordings};
use super::stop_kind::{cue_tone, interruption_kind, protocol_safety, stop_kind};
use super::wiring::{Admit, BeginRecording, Wiring};
use journal::Entry;
use live::carrier_decision::CarrierEffect;
use live::live_side::FitNews;
use live::{past_trials, screen_words};

/// Task that steps the protocol.
pub struct SessionTask {
    machine: protocols::Session,
    bench: Arc<Effective>,
    admit: Admit,
    begin: BeginRecording,
    wiring: Wiring,
    /// Whether the session runs without an operator to ask.
    unattended: bool,
    commands: VecDeque<OperatorCommand>,
    consent: Consent,
    record: Measurements,
    collecting: bool,
    /// Carrier of the latest recording, Hz.
    carrier_hz: f64,
    account: Account,
    account_at_begin: Account,
    due_trial: Option<DueTrial>,
    analysed: Option<TrialAnalysis>,
    audio_s: f64,
    normal_n: Option<f64>,
    view: Option<ParticipantView>,
    phase: Option<tui::event::PhaseView>,
    safety: SafetyState,
    /// The event that the next trial follows, if it does not follow another trial.
    resumed: Option<&'static str>,
    recordings: Recordings,
    /// Whether a trip requested by this task is still to come.
    tripping: bool,
    outcome: Option<SessionOutcome>,
    /// Reason for the last automatic pause.
    paused: Option<String>,
    report: Sender<Report>,
    glance: AtAGlance,
}

impl SessionTask {
    /// Returns a session about to take its first step. `consent_by` is the operator who holds the signed consent, if
    /// there is one yet.
    #[expect(
        clippy::too_many_arguments,
        reason = "the composition root names each once"
    )]
    pub fn new(
        machine: protocols::Session,
        bench: Arc<Effective>,
        admit: Admit,
        begin: BeginRecording,
        wiring: Wiring,
        consent_by: Option<String>,
        questions: Questions,
        unattended: bool,
        report: Sender<Report>,
    ) -> Self {
        let mut task = Self {
            machine,
            bench,
            admit,
            begin,
            wiring,
            unattended,
            commands: VecDeque::new(),
            consent: Consent::new(questions),
            record: Measurements::default(),
            collecting: false,
            carrier_hz: f64::NAN,
            account: Account::default(),
            account_at_begin: Account::default(),
            due_trial: None,
            analysed: None,
            audio_s: 0.0,
            normal_n: None,
            view: None,
            phase: None,
            safety: SafetyState::Disarmed,
            resumed: None,
            recordings: Recordings::default(),
            tripping: false,
            outcome: None,
            paused: None,
            report,
            glance: AtAGlance::default(),
        };
        if let Some(operator) = consent_by {
            let effects = task.consent.give(operator);
            task.take_answer(effects);
        }
        task
    }

    fn log(&mut self, level: LogLevel, text: impl Into<String>) {
        self.wiring.front.show(tui::Event::Log {
            level,
            text: text.into(),
        });
    }

    fn take_batches(&mut self) {
        let mut dropped = None;
        for mut batch in self.wiring.batches.try_iter() {
            dropped = dropped.or_else(|| BatchesDropped::dropped_before(&batch));
            self.audio_s = batch.audio_s;
            self.account = batch.account;
            self.normal_n = batch.force.last().map(|row| row.normal_n).or(self.normal_n);
            let position_m = batch.position.last().map(|row| row.position_m);
            self.wiring.displays.beat(batch.audio_s, position_m);
            self.wiring.live.take(&batch);
            for text in std::mem::take(&mut batch.warnings) {
                let level = LogLevel::Warning;
                self.wiring.front.show(tui::Event::Log { level, text });
            }
            if self.collecting {
                self.record.take(batch);
            }
        }
        if let Some(dropped) = dropped {
            self.fail(dropped.to_string());
        }
    }

    fn take_notices(&mut self) {
        let rate_hz = self.bench.config().audio.rate_hz;
        while let Ok(notice) = self.wiring.notices.try_recv() {
            let Some(end) = saved::ending(notice, self.audio_s, rate_hz) else {
                continue;
            };
            let news = self.recordings.end(&end);
            match end.outcome {
                Ok(entry) => self.wiring.journal.send(entry),
                Err(message) if news => self.fail(message),
                Err(message) => self.log(LogLevel::Warning, message),
            }
        }
        let overflow = self.recordings.overflow(&self.wiring.gauge);
        let log_loss = self.recordings.log_loss(&self.wiring.journal);
        for message in [overflow, log_loss].into_iter().flatten() {
            self.fail(message);
        }
    }

    /// Stops the drive because its data cannot be kept.
    fn fail(&mut self, message: String) {
        self.log(LogLevel::Error, &message);
        self.wiring.drive.trip(Trip::Fault { message });
        self.tripping = true;
    }

    fn take_actions(&mut self) -> anyhow::Result<()> {
        while let Some(action) = self.wiring.front.action() {
            let practices = self.machine.protocol().trials.practice;
            match OperatorRequest::from_action(action, practices) {
                OperatorRequest::Command(command) => {
                    if command == OperatorCommand::Resume {
                        self.wiring.reconnect_displays();
                    }
                    self.commands.push_back(command);
                }
                OperatorRequest::Consent => {
                    let effects = self.consent.give("operator at the dashboard".to_owned());
                    self.take_answer(effects);
                }
                OperatorRequest::Reply(reply) => {
                    let effects = self.consent.reply(reply);
                    self.take_answer(effects);
                }
                OperatorRequest::Carrier(take) => {
                    let effects = self.wiring.carrier.answer(take);
                    self.carry_out(effects)?;
                }
                OperatorRequest::Stop => self.wiring.drive.trip(Trip::Operator),
                OperatorRequest::Rearm => self.wiring.drive.rearm(),
                OperatorRequest::End => self.wiring.stop.raise(),
                OperatorRequest::Nothing => {}
            }
        }
        Ok(())
    }

    /// Changes the carrier of later trials once that is decided, while nothing is driven or recorded.
    fn change_carrier(&mut self) -> anyhow::Result<()> {
        let at_rest = !self.collecting && !self.wiring.drive.sounds();
        let effects = self.wiring.carrier.poll(&self.bench, at_rest, self.audio_s);
        self.carry_out(effects)
    }

    fn carry_out(&mut self, effects: Vec<CarrierEffect>) -> anyhow::Result<()> {
        for effect in effects {
            match effect {
                CarrierEffect::Show(event) => self.wiring.front.show(*event),
                CarrierEffect::Record(data) => {
                    let t_s = self.audio_s;
                    self.wiring.journal.send(Entry::Live { t_s, data });
                }
                CarrierEffect::Change(by_hz, bench) => {
                    let carrier_hz = bench.config().plate.resonance_hz;
                    let tuning = Tuning::new(bench.config(), carrier_hz)?;
                    self.send(RecordingCommand::Retune(Box::new(tuning)));
                    self.wiring.carrier_hz.set(carrier_hz);
                    self.wiring.live.retune(by_hz);
                    self.bench = Arc::from(bench);
                }
            }
        }
        Ok(())
    }

    fn take_answer(&mut self, effects: AnswerEffects) {
        if let Some(person) = effects.person {
            self.wiring.journal.send(Entry::Person(person));
        }
        if let Some(event) = effects.event {
            self.wiring.front.show(event);
        }
        self.commands.extend(effects.command);
    }

    /// Analyses a completed trial as soon as all of its data have arrived.
    fn analyse(&mut self) {
        let context = (self.machine.protocol(), &*self.bench);
        for crop in self.glance.crops(self.audio_s, &self.record, context) {
            self.wiring.front.show(tui::Event::Crop(crop));
        }
        let Some(due_trial) = self
            .due_trial
            .take_if(|due_trial| self.audio_s >= due_trial.at_s + DATA_DELAY_S)
        else {
            return;
        };
        self.collecting = false;
        self.send(RecordingCommand::End(Ending::Completed));
        let analysed = due_trial.analyse(
            (self.machine.protocol(), &self.bench, self.carrier_hz),
            std::mem::take(&mut self.record),
            (&self.account, &self.account_at_begin),
        );
        self.wiring.live.ask(analysed.request, analysed.attempt);
        self.analysed = Some(analysed.analysis);
    }

    fn take_fits(&mut self) {
        while let Some(FitNews { lines, data, view }) = self.wiring.live.take_fit() {
            let t_s = self.audio_s;
            self.wiring.journal.send(Entry::Live { t_s, data });
            self.wiring.front.show(tui::Event::Fit(view));
            for line in lines {
                self.log(LogLevel::Info, line);
            }
        }
    }

    fn step(&mut self) -> anyhow::Result<()> {
        let observation = Observation {
            t_s: self.audio_s,
            normal_n: self.normal_n,
            button_pressed: self.wiring.readiness.is_confirmed(
                self.audio_s,
                self.view.as_ref(),
                self.normal_n,
            ),
            command: self.commands.pop_front(),
            safety: protocol_safety(&self.safety),
            hold: self.wiring.signals.hold.get().map(screen_words::hold),
            drive_wait_s: self.wiring.drive_wait_s(),
            asking: self.wiring.carrier.is_open(),
            display_lost: self.wiring.displays.loss().map(str::to_owned),
            attended: !self.unattended,
            analysis: self.analysed.clone(),
            recording: self.recordings.outcome(),
            recorder_lag_s: self.wiring.behind_s(),
        };
        let mut tone = None;
        let halted = |phase| matches!(phase, Phase::Paused | Phase::Fault);
        let before = self.machine.phase();
        let actions = self.machine.step(&observation);
        if halted(before) && !halted(self.machine.phase()) {
            self.paused = None;
            self.resumed = Some(match before {
                Phase::Fault => "after a fault",
                _ => "after a pause",
            });
        }
        for action in actions {
            match action {
                Action::BeginTrial { key, drive, .. } => self.begin_trial(&key, &drive)?,
                Action::Drive(DriveRequest::On(drive)) => {
                    let program = (self.admit)(&drive, &self.bench)?;
                    self.wiring.drive.start(program);
                    self.mask(true);
                }
                Action::Drive(DriveRequest::Off) => {
                    self.wiring.drive.stop();
                    self.mask(false);
                }
                Action::Mark(interval) => self.send(RecordingCommand::Interval(interval)),
                Action::EndTrial { end, .. } => self.end_trial(&end),
                Action::AnalyseTrial { key, intervals } => {
                    self.due_trial = Some(DueTrial {
                        key,
                        intervals,
                        at_s: self.audio_s,
                    });
                }
                Action::Verdict { key, verdict } => self.take_verdict(&key, &verdict)?,
                Action::Cue(cue) => {
                    let cue = cue_tone(cue);
                    if let Some(sound) = &self.wiring.sound {
                        sound.play(cue);
                    }
                    tone = Some(cue);
                }
                Action::Log(event) => self.tell(event),
                Action::Show(view) => self.show(view, tone.take()),
                Action::Finished(outcome) => {
                    let withdrawn = self.wiring.carrier.withdraw("the session ended");
                    self.carry_out(withdrawn)?;
                    self.wiring.drive.disarm();
                    self.wiring.front.show(tui::Event::Finished {
                        summary: summary_lines(&self.machine.summary(), &self.account),
                    });
                    self.outcome = Some(outcome);
                }
            }
        }
        Ok(())
    }

    fn send(&self, command: RecordingCommand) {
        // The acquisition ends before the session only if it failed, which stops the bench.
        let _ = self.wiring.recording.send(command);
    }

    /// Adds an event to the open recording, if there is one.
    fn mark(&self, kind: EventKind, text: impl Into<String>) {
        self.send(RecordingCommand::Event(kind, Some(text.into())));
    }

    fn mask(&self, is_masked: bool) {
        if let Some(sound) = &self.wiring.sound {
            sound.mask(is_masked);
        }
    }

    fn begin_trial(&mut self, key: &TrialKey, drive: &protocols::Drive) -> anyhow::Result<()> {
        let withdrawn = self.wiring.carrier.withdraw("a trial began");
        self.carry_out(withdrawn)?;
        let begin = (self.begin)(key, drive, &self.bench)?;
        self.carrier_hz = begin.manifest.carrier_hz;
        self.wiring.live.modulate(drive.modulation_hz);
        self.recordings.begin(key.clone(), begin.folder.clone());
        self.send(RecordingCommand::Begin(Box::new(begin)));
        if let Some(text) = self.resumed.take() {
            self.mark(EventKind::Resume, text);
        }
        if key.attempt > 1 {
            self.mark(EventKind::Redo, format!("attempt {}", key.attempt));
        }
        self.glance
            .begin(key, self.machine.protocol(), self.audio_s);
        self.record = Measurements::default();
        self.collecting = true;
        self.account_at_begin = self.account;
        self.analysed = None;
        Ok(())
    }

    fn end_trial(&mut self, end: &TrialEnd) {
        // The recording of a completed trial continues until its last data are in.
        if let TrialEnd::Interrupted { interruption } = end {
            self.collecting = false;
            self.due_trial = None;
            self.glance.broken_off();
            self.mark(interruption_kind(interruption), interruption.to_string());
            self.send(RecordingCommand::End(end.into()));
        }
    }

    fn take_verdict(&mut self, key: &TrialKey, verdict: &Verdict) -> anyhow::Result<()> {
        self.glance.judged(self.audio_s);
        let analysis = self.analysed.take();
        let entry = screen_words::verdict(key, self.machine.protocol(), verdict, analysis.as_ref());
        self.wiring.front.show(tui::Event::Verdict(entry));
        if self.machine.trials_left() <= 1 && *verdict == Verdict::Accepted {
            return Ok(());
        }
        let drift_hz = self.wiring.live.drift_hz();
        let effects = self
            .wiring
            .carrier
            .judge(drift_hz, &self.bench, self.audio_s);
        self.carry_out(effects)
    }

    fn tell(&mut self, event: SessionEvent) {
        if let Some(reason) = pause(&event.kind) {
            self.log(LogLevel::Warning, &reason);
            self.paused = Some(reason);
        }
        match &event.kind {
            SessionEventKind::SessionStarted {
                resumed_attempts: 1..,
                ..
            } => self.resumed = Some("after the program's end"),
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
                    self.log(LogLevel::Warning, text);
                }
                if let Some(reason) = saved::not_saved(record).filter(|_| !self.tripping) {
                    self.fail(reason);
                }
            }
            SessionEventKind::Marked { interval } => self.glance.mark(interval),
            SessionEventKind::SafetyTripped { reason } => {
                self.mark(stop_kind(&self.safety), reason);
            }
            _ => {}
        }
        if let Some((level, text)) = screen_words::notice(&event.kind) {
            self.log(level, text);
        }
        self.wiring.journal.send(Entry::Event(event));
    }

    fn show(&mut self, view: ParticipantView, tone: Option<Tone>) {
        let phase = screen_words::phase(&self.machine, &view);
        if self.phase.as_ref() != Some(&phase) {
            self.wiring.front.show(tui::Event::Phase(phase.clone()));
            self.phase = Some(phase);
        }
        if tone.is_some() || self.view.as_ref() != Some(&view) {
            let screen_view = self.wiring.screen.view(&view, self.audio_s);
            self.wiring.displays.show(&screen_view);
            for watcher in &mut self.wiring.watchers {
                watcher(&screen_view, view.button, tone);
            }
            self.wiring.front.show(tui::Event::Participant(screen_view));
            self.view = Some(view);
        }
    }

    fn feed_screen(&mut self, now_ns: u64) {
        let session = (&self.machine, self.view.as_ref());
        let audio = (&self.account, self.bench.config().audio.rate_hz);
        let times = (now_ns, self.audio_s);
        if self.glance.feed(&mut self.wiring, session, audio, times) {
            self.show_safety();
        }
    }

    /// Reports a stop that the protocol's state machine does not: a stop with a new reason, such as a plate that is alive
    /// after it, or a stop after the session's end.
    fn alarm(&mut self, before: &SafetyState) {
        let SafetyState::Tripped { trip } = &self.safety else {
            return;
        };
        if matches!(before, SafetyState::Tripped { .. }) || self.outcome.is_some() {
            let reason = trip.to_string();
            self.tell(SessionEvent {
                t_s: self.audio_s,
                kind: SessionEventKind::SafetyTripped { reason },
            });
        }
    }

    fn show_safety(&mut self) {
        let left = self.wiring.signals.dose.get();
        let event = safety_event(&self.safety, self.wiring.drive.sounds(), left.as_ref());
        self.wiring.front.show(event);
    }

    /// Ends a session without an operator where one would be needed.
    fn nobody_to_ask(&mut self) {
        if !self.unattended || self.outcome.is_some() || self.tripping {
            return;
        }
        match self.machine.phase() {
            Phase::Fault | Phase::Paused => self.wiring.stop.raise(),
            Phase::Consent if self.commands.is_empty() => self.wiring.stop.raise(),
            _ => {}
        }
    }

    fn end_state(&self) -> EndState<'_> {
        EndState {
            paused: self.paused.as_deref(),
            failure: self.wiring.stop.failure(),
            safety: &self.safety,
            outcome: self.outcome.as_ref(),
            phase: self.machine.phase(),
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
        let safety = self.wiring.signals.state.get().unwrap_or_default();
        self.tripping &= !matches!(safety, SafetyState::Tripped { .. });
        if safety != self.safety {
            let before = std::mem::replace(&mut self.safety, safety);
            self.alarm(&before);
            self.show_safety();
        }
        self.wiring.drive.poll(&self.safety);
        self.take_batches();
        self.take_notices();
        self.take_fits();
        self.wiring.look_at_displays();
        self.take_actions()?;
        self.change_carrier()?;
        self.analyse();
        self.step()?;
        self.feed_screen(now_ns);
        self.nobody_to_ask();
        if self.outcome.is_some() && self.unattended && !self.recordings.is_open() {
            self.wiring.stop.raise();
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.wiring.drive.stop();
        // The last batches contain the count of the last losses.
        self.take_batches();
        let reason = self.end_state().reason();
        if self.recordings.is_open() {
            let reason = reason.clone().unwrap_or_default();
            self.send(RecordingCommand::End(Ending::Interrupted { reason }));
        }
        let completed = matches!(self.outcome, Some(SessionOutcome::Completed { .. }));
        let status = self.end_state().status();
        self.wiring.journal.send(Entry::Stop {
            t_s: self.audio_s,
            status,
            reason: reason.clone(),
        });
        let summary = self.machine.summary();
        let _ = self.report.send(Report {
            summary,
            account: self.account,
            completed,
            reason,
        });
        Ok(())
    }
}
