//! The bench under calibration: plays the procedure's tones, captures every sample, asks the operator, and passes the
//! outcome of each step to the procedure.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail};
use config::{Effective, Force, Identity};
use crossbeam_channel::{Receiver, Sender};
use devices::drive_control::DriveControl;
use devices::field_task::FieldReading;
use devices::{Boot, DeviceReadings, DriveLedger, Hardware, Life, OpenHardware};
use jiff::Timestamp;
use operator_ui::bench_page::HealthMeter;
use operator_ui::console::DashboardThread;
use safety::{SafetyState, Signals, Trip};
use signalgen::{BlockHeader, DrivePhase, InputReader, StreamDirection};
use tasks::{StopFlag, Task};

use crate::admission::Admission;
use crate::broken_off::{BrokenOff, EndedEarly};
use crate::capture::{Capture, dwells, last_tone};
use crate::drop_outs::DropOuts;
use crate::known::Instrument;
use crate::meter::Meter;
use crate::operator::{Hands, LiveReading, Operator, OperatorInput};
use crate::procedure::{HELD_S, NextStep, Procedure, StepOutcome};
use crate::rig_step::{HeldTone, Step};
use crate::watched_inputs::WatchedInputs;

/// A completed measurement.
pub struct Outcome<P> {
    /// Procedure, with its measurements.
    pub procedure: P,
    /// Identity of the measured bench.
    pub identity: Identity,
    /// Date of the measurement.
    pub date: Timestamp,
    /// Whether the date is of simulated time.
    pub simulated_time: bool,
    /// Time for which the plate was driven, s.
    pub driven_s: f64,
    /// Number of xruns; they did not affect any measured sample.
    pub xruns: u64,
    /// Note on the form of the instrument's numbers, if they have decimal commas.
    pub instrument_note: Option<String>,
}

/// The operator, and the thread of their screen if there is one.
pub type AttendingOperator = (Box<dyn Operator>, Option<DashboardThread>);

/// Runs `procedure` on the bench, and adds its driving time and heating to `ledger`. `attend` opens the operator's screen once
/// the bench is open; quitting the screen ends the bench.
///
/// # Errors
/// If a part of the bench is missing or fails, samples are lost, the safety watch trips, the operator quits, or the procedure
/// fails; [`EndedEarly`] if no operator is present to continue.
pub fn run<P: Procedure>(
    bench: &Effective,
    hardware: Hardware,
    ledger: DriveLedger,
    hands: Option<Hands>,
    instrument: Option<Instrument>,
    attend: impl FnOnce(&Life) -> anyhow::Result<AttendingOperator>,
    procedure: P,
) -> anyhow::Result<Outcome<P>> {
    let config = bench.config();
    let admission = Admission::new(config)?;
    // The dead-man switch is not held, since the calibration asks for a clear plate. The calibration limits the amplitude
    // itself.
    let unattended = bench.clone().without_dead_man().without_amplitude_limit();
    let mut open = OpenHardware::open(&unattended, hardware)?;
    open.charge(ledger, Boot::now())?;
    let [input, output] = [StreamDirection::Input, StreamDirection::Output]
        .map(|direction| open.life.device(direction));
    let identity =
        Identity::from_config(config, input, output).with_sound_card(devices::sound_card(config));
    let stop = open.life.stop().clone();
    let (operator, screen) = attend(&open.life)?;
    let (done, outcome) = crossbeam_channel::bounded(1);
    let rate_hz = f64::from(config.audio.rate_hz);
    let task = RigTask {
        ramp_frames: admission.ramp_frames(),
        admission,
        channels: open.input.channels(),
        watched: WatchedInputs::new(config, open.input.channels()),
        tail_frames: (config.safety.loop_latency_s * rate_hz) as usize,
        held_frames: (HELD_S * rate_hz) as usize,
        expects_force: config.force.is_some(),
        force_check: config.force.as_ref().map_or("", Force::what_to_check),
        rate_hz,
        input: open.input,
        readings: open.readings,
        drive: open.drive,
        signals: open.signals,
        gauges: open.gauges,
        health: HealthMeter::default(),
        instrument,
        operator,
        hands,
        stop: stop.clone(),
        procedure: Some(procedure),
        step: Step::Settling,
        last_step: None,
        tone: None,
        capture: Capture::default(),
        block: Vec::new(),
        meter: Meter::default(),
        drop_outs: DropOuts::default(),
        driven_frames: 0,
        last_audio_ns: None,
        done,
    };
    let mut tasks = open.tasks;
    tasks.push(Box::new(task));
    let clock = open.life.clock().clone();
    open.life
        .run(tasks, || screen.map_or(Ok(()), DashboardThread::join))?;
    let (procedure, driven_s, xruns, instrument_note) = outcome
        .try_recv()
        .ok()
        .context("quit before the results were accepted: nothing was written")?;
    Ok(Outcome {
        procedure,
        identity,
        date: clock.utc(),
        simulated_time: clock.is_simulated(),
        driven_s,
        xruns,
        instrument_note,
    })
}

/// Length of the silence before the first step, s, in which the force sensor's clock and the card settle.
const SETTLE_S: f64 = 0.2;
/// Longest time for which a tone is held for an operator who may have left, s.
const HELD_MOST_S: f64 = 300.0;
/// Time between two readings shown to the operator, s.
const SHOW_S: f64 = 0.05;
/// Answer to a step begun again before the bench is re-armed.
const STILL_STOPPED: &str = "The bench is still stopped: press x to re-arm it first.";
/// Time without audio that ends the calibration, on the bench's clock.
const CARD_TIMEOUT: Duration = Duration::from_secs(10);

struct RigTask<P> {
    admission: Admission,
    ramp_frames: usize,
    channels: usize,
    watched: WatchedInputs,
    tail_frames: usize,
    held_frames: usize,
    expects_force: bool,
    /// Advice for a force sensor that sends nothing.
    force_check: &'static str,
    rate_hz: f64,
    input: InputReader,
    readings: Receiver<FieldReading>,
    drive: DriveControl,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    health: HealthMeter,
    instrument: Option<Instrument>,
    operator: Box<dyn Operator>,
    hands: Option<Hands>,
    stop: StopFlag,
    procedure: Option<P>,
    step: Step,
    /// Step begun last, for a repetition.
    last_step: Option<NextStep>,
    tone: Option<HeldTone>,
    capture: Capture,
    block: Vec<f32>,
    meter: Meter,
    drop_outs: DropOuts,
    driven_frames: u64,
    last_audio_ns: Option<u64>,
    done: Sender<(P, f64, u64, Option<String>)>,
}

impl<P: Procedure> RigTask<P> {
    fn take_block(&mut self, header: &BlockHeader, now_ns: u64) -> anyhow::Result<()> {
        let xrun = self.drop_outs.take(header)?;
        let silent = header.drive.phase.is_silent();
        if !silent {
            self.driven_frames += u64::from(header.frames);
        }
        self.watched
            .publish(&self.block, header, now_ns, &self.signals)?;
        self.meter
            .take(&self.block, self.channels, self.watched.channels());
        self.capture.samples.extend_from_slice(&self.block);
        let frames = self.frames();
        match &mut self.step {
            Step::Playing {
                started,
                programs_before,
                end_frame,
                ..
            } => {
                if header.drive.programs != *programs_before && !silent && !*started {
                    *started = true;
                    self.capture.began = Some(frames - header.frames as usize);
                }
                if *started && silent && end_frame.is_none() {
                    *end_frame = Some(frames);
                }
            }
            Step::SilencingTone { quiet_frames, .. } if silent => {
                *quiet_frames += header.frames as usize;
            }
            // A gap in silence cannot be detected, so the silence is repeated.
            Step::Listening { .. } if xrun => {
                self.drop_outs.listen_anew()?;
                self.capture.forget(frames);
            }
            Step::Asking { .. } if frames > 2 * self.held_frames => {
                self.capture.forget(frames - self.held_frames);
            }
            _ => {}
        }
        if let Some(tone) = &mut self.tone {
            let steady = header.drive.programs != tone.programs_before
                && header.drive.phase == DrivePhase::Steady;
            // The reading of the tone restarts after an xrun.
            tone.steady_frames = if steady && !xrun {
                tone.steady_frames + header.frames as usize
            } else {
                0
            };
        }
        Ok(())
    }

    fn frames(&self) -> usize {
        self.capture.samples.len() / self.channels
    }

    /// Begins a step once the previous tone is silent.
    fn begin(&mut self, next: NextStep) -> anyhow::Result<()> {
        self.last_step = Some(next.clone());
        let goes_on = match (&self.tone, &next) {
            (None, _) => true,
            (Some(tone), NextStep::Sound(waveform, _)) => tone.waveform == **waveform,
            _ => false,
        };
        if goes_on {
            return self.begin_now(next);
        }
        self.tone = None;
        self.drive.stop();
        self.step = Step::SilencingTone {
            next: Some(next),
            quiet_frames: 0,
        };
        Ok(())
    }

    fn begin_now(&mut self, next: NextStep) -> anyhow::Result<()> {
        self.capture = Capture {
            channels: self.channels,
            rate_hz: self.rate_hz,
            from_s: self.drop_outs.frames as f64 / self.rate_hz,
            ..Capture::default()
        };
        self.drop_outs.begin();
        let question = match &next {
            NextStep::Ask(request) | NextStep::Sound(_, request) => Some(*request),
            NextStep::Listen(_) | NextStep::Play(_) | NextStep::Done => None,
        };
        self.step = match next {
            NextStep::Listen(seconds) => Step::Listening {
                until: (seconds * self.rate_hz) as usize,
            },
            NextStep::Play(waveform) => {
                self.drive.start(self.admission.admit(*waveform)?);
                Step::Playing {
                    waveform,
                    started: false,
                    programs_before: self.drive.programs(),
                    end_frame: None,
                }
            }
            NextStep::Sound(waveform, _) if self.tone.is_none() => {
                self.drive.start(self.admission.admit(*waveform)?);
                self.tone = Some(HeldTone {
                    waveform: *waveform,
                    programs_before: self.drive.programs(),
                    steady_frames: 0,
                });
                Step::Asking { answer: None }
            }
            NextStep::Sound(..) => Step::Asking { answer: None },
            NextStep::Ask(_) => {
                // The operator is about to touch cables or the plate.
                self.drive.disarm();
                Step::Asking { answer: None }
            }
            NextStep::Done => Step::Done,
        };
        self.operator.ask(question.as_ref());
        if let (Some(hands), Some(request)) = (&mut self.hands, &question) {
            hands(request);
        }
        Ok(())
    }

    /// Returns the outcome of the present step; `None` until it is finished.
    fn finished(&mut self) -> anyhow::Result<Option<StepOutcome>> {
        let frames = self.frames();
        if let (Some(tone), Step::Asking { answer: None }) = (&self.tone, &self.step)
            && tone.steady_frames as f64 > HELD_MOST_S * self.rate_hz
        {
            let why = format!(
                "timed out waiting {:.0} minutes for the operator's answer while the plate moved; the drive was stopped",
                HELD_MOST_S / 60.0
            );
            return Err(BrokenOff(why).into());
        }
        match &self.step {
            Step::Settling if frames as f64 > SETTLE_S * self.rate_hz => {
                Ok(Some(StepOutcome::Began))
            }
            Step::Listening { until } if frames >= *until => self.captured().map(Some),
            Step::Playing {
                waveform,
                end_frame: Some(end_frame),
                ..
            } if frames >= end_frame + self.tail_frames => {
                let waveform = **waveform;
                self.capture.dwells = dwells(
                    &self.capture,
                    &waveform,
                    self.watched.drive,
                    self.ramp_frames,
                )?;
                self.drop_outs
                    .require_whole(&self.capture, self.watched.drive)?;
                self.captured().map(Some)
            }
            Step::Asking {
                answer: Some(answer),
            } => {
                let answer = *answer;
                if let Some(tone) = &self.tone {
                    // The read-back and the pickup lag behind the drive.
                    if tone.steady_frames < self.tail_frames + self.held_frames
                        || frames < self.held_frames
                    {
                        return Ok(None);
                    }
                    self.capture.dwells =
                        last_tone(&self.capture, &tone.waveform, self.held_frames);
                    self.require_force()?;
                }
                let capture = std::mem::take(&mut self.capture);
                Ok(Some(StepOutcome::Answered(answer, capture)))
            }
            _ => Ok(None),
        }
    }

    fn captured(&mut self) -> anyhow::Result<StepOutcome> {
        self.require_force()?;
        Ok(StepOutcome::Captured(std::mem::take(&mut self.capture)))
    }

    fn require_force(&self) -> anyhow::Result<()> {
        if self.expects_force && self.capture.normal_n.is_empty() {
            bail!("the force sensor sends nothing: {}", self.force_check);
        }
        Ok(())
    }

    fn advance(&mut self) -> anyhow::Result<()> {
        if let Step::SilencingTone { next, quiet_frames } = &mut self.step
            && *quiet_frames >= self.tail_frames
            && let Some(next) = next.take()
        {
            self.begin_now(next)?;
        }
        while let Some(outcome) = self.finished()? {
            let Some(procedure) = &mut self.procedure else {
                return Ok(());
            };
            let next = procedure.next(outcome)?;
            self.operator.progress(&procedure.progress());
            self.begin(next)?;
        }
        if matches!(self.step, Step::Done) {
            self.stop.raise();
        }
        Ok(())
    }

    fn take_inputs(&mut self) -> anyhow::Result<()> {
        while let Some(input) = self.operator.next_input()? {
            match (input, &mut self.step) {
                (OperatorInput::Answer(reply), Step::Asking { answer }) => *answer = Some(reply),
                // A late answer belongs to an earlier request.
                (OperatorInput::Answer(_), _) => {}
                (OperatorInput::Leave, _) => self.stop.raise(),
                (OperatorInput::Stop, _) => self.drive.trip(Trip::Operator),
                // The watch has not tripped in this state.
                (OperatorInput::Rearm, _) => {}
            }
        }
        Ok(())
    }

    /// Reads audio, forces and the instrument.
    fn take_in(&mut self, now_ns: u64) -> anyhow::Result<()> {
        while let Some(header) = self.input.pop_block(&mut self.block) {
            self.last_audio_ns = Some(now_ns);
            self.take_block(&header, now_ns)?;
        }
        for reading in self.readings.try_iter() {
            if let FieldReading::Force(force) = reading {
                self.capture.take_force(&force);
                let (normal, lateral, count) = self.meter.force;
                self.meter.force = (
                    normal + force.normal_n,
                    lateral + force.lateral_n,
                    count + 1,
                );
            }
        }
        let frames = self.frames();
        if let Some(instrument) = &mut self.instrument {
            let (capture, meter) = (&mut self.capture.known_m, &mut self.meter);
            instrument.poll(|amplitude_m| {
                capture.push((frames, amplitude_m));
                meter.known_m = Some(amplitude_m);
            })?;
        }
        Ok(())
    }

    fn show(&mut self, safety: &SafetyState) {
        if (self.meter.frames as f64) < SHOW_S * self.rate_hz {
            return;
        }
        self.operator.show(&LiveReading {
            t_s: self.drop_outs.frames as f64 / self.rate_hz,
            safety: safety.clone(),
            sounds: self.drive.sounds(),
            dose: self.signals.dose.get(),
            ..self.meter.reading(&self.watched, self.instrument.as_ref())
        });
    }

    fn show_health(&mut self, now_ns: u64) {
        self.gauges.ring_fill.set(self.input.ring_fill());
        let (account, rate_hz) = (self.drop_outs.account(), self.rate_hz as u32);
        let now = self.health.read(now_ns, &account, &self.gauges, rate_hz);
        now.iter().for_each(|now| self.operator.health(now));
    }

    fn work(&mut self, safety: &SafetyState, now_ns: u64) -> anyhow::Result<()> {
        if let SafetyState::Tripped { trip } = safety {
            return Err(BrokenOff::from_trip(trip).into());
        }
        self.drive.poll(safety);
        self.take_in(now_ns)?;
        self.require_card(now_ns)?;
        self.show(safety);
        self.take_inputs()?;
        self.advance()
    }

    /// Breaks the step off and keeps earlier measurements; returns whether an operator is present to continue.
    fn break_off(&mut self, why: &BrokenOff) -> bool {
        let why = why.to_string();
        let state = self.signals.state.get().unwrap_or_default();
        let is_tripped = matches!(state, SafetyState::Tripped { .. });
        let lost = self.drive.rearm_obstacle().map(|lost| lost.to_string());
        let obstacle = lost.as_deref().unwrap_or(STILL_STOPPED);
        if !self
            .operator
            .broken_off(&why, is_tripped.then_some(obstacle))
        {
            return false;
        }
        self.tone = None;
        self.step = Step::BrokenOff {
            why,
            next_step: self.last_step.clone(),
        };
        true
    }

    /// Waits for the operator to re-arm and to restart the step.
    fn after_break(&mut self, safety: &SafetyState, now_ns: u64) -> anyhow::Result<()> {
        self.drive.poll(safety);
        // Samples lost now would not have been used.
        if let Err(error) = self.take_in(now_ns)
            && !error.is::<BrokenOff>()
        {
            return Err(error);
        }
        self.require_card(now_ns)?;
        self.capture = Capture {
            channels: self.channels,
            ..Capture::default()
        };
        self.show(safety);
        while let Some(wish) = self.operator.next_input()? {
            let Step::BrokenOff { why, next_step } = &mut self.step else {
                return Ok(());
            };
            let is_stopped = matches!(safety, SafetyState::Tripped { .. }) || self.drive.sounds();
            let obstacle = self.drive.rearm_obstacle().map(|why| why.to_string());
            let obstacle = obstacle.as_deref();
            match wish {
                OperatorInput::Rearm => {
                    self.drive.rearm();
                    self.operator.broken_off(why, obstacle);
                }
                OperatorInput::Stop => self.drive.trip(Trip::Operator),
                OperatorInput::Leave => self.stop.raise(),
                OperatorInput::Answer(_) if is_stopped => {
                    self.operator
                        .broken_off(why, Some(obstacle.unwrap_or(STILL_STOPPED)));
                }
                OperatorInput::Answer(_) => match next_step.take() {
                    Some(next) => self.begin(next)?,
                    None => self.step = Step::Settling,
                },
            }
        }
        Ok(())
    }

    fn require_card(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let last_ns = *self.last_audio_ns.get_or_insert(now_ns);
        if Duration::from_nanos(now_ns.saturating_sub(last_ns)) > CARD_TIMEOUT {
            let s = CARD_TIMEOUT.as_secs();
            bail!("audio callbacks stopped: the sound card has delivered nothing for {s} s");
        }
        Ok(())
    }

    /// Keeps the screen of a failed measurement until the operator quits.
    fn after_failure(&mut self, safety: &SafetyState, now_ns: u64) -> anyhow::Result<()> {
        // Samples lost now would not have been used.
        let _ = self.take_in(now_ns);
        self.capture = Capture::default();
        self.show(safety);
        while let Some(wish) = self.operator.next_input()? {
            match wish {
                OperatorInput::Stop => self.drive.trip(Trip::Operator),
                OperatorInput::Leave | OperatorInput::Answer(_) => self.stop.raise(),
                OperatorInput::Rearm => {}
            }
        }
        Ok(())
    }
}

impl<P: Procedure> Task for RigTask<P> {
    fn name(&self) -> &'static str {
        "calibration"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(1)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let safety = self.signals.state.get().unwrap_or_default();
        self.show_health(now_ns);
        if matches!(self.step, Step::Failed(_)) {
            return self.after_failure(&safety, now_ns);
        }
        let result = match self.step {
            Step::BrokenOff { .. } => self.after_break(&safety, now_ns),
            _ => self.work(&safety, now_ns),
        };
        let Err(error) = result else {
            return Ok(());
        };
        self.drive.disarm();
        if let Some(why) = error.downcast_ref::<BrokenOff>()
            && self.break_off(why)
        {
            return Ok(());
        }
        if !self
            .operator
            .failed(&bounded_files::cause_line(error.as_ref()))
        {
            let progress = self.procedure.as_ref().map(P::progress);
            return Err(EndedEarly::from_progress(progress, error).into());
        }
        self.step = Step::Failed(error);
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        self.operator.close();
        match std::mem::replace(&mut self.step, Step::Done) {
            Step::Failed(error) => return Err(error),
            Step::Done => {
                if let Some(procedure) = self.procedure.take() {
                    let driven_s = self.driven_frames as f64 / self.rate_hz;
                    let note = self.instrument.as_ref().and_then(Instrument::note);
                    let xruns = self.drop_outs.xruns();
                    let note = note.map(str::to_owned);
                    let _ = self.done.send((procedure, driven_s, xruns, note));
                }
            }
            _ => {}
        }
        Ok(())
    }
}
