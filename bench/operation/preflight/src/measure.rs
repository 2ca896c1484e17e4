//! The measurement: silence, then a faint tone at the carrier, while all inputs are recorded.

use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender};
use impedance::ZmFrame;
use signalgen::Waveform;

use crate::extent::Extent;
use config::Effective;
use devices::acquisition::RecordingCommand;
use devices::drive_control::{DriveControl, settings};
use devices::excerpt::Excerpt;
use devices::{Bench, DeviceReadings, Hardware, SensorClocks, ThreadPriorities};
use recording::pipeline::{Account, Batch};
use safety::{FAINT_V, LoopDelay, Pace, SafetyState, Signals, StopTimes};
use tasks::{StopFlag, Task};

/// Peak of the test tone, V: far below the threshold of touch.
const TONE_V: f64 = FAINT_V;
/// Silence before the tone, s.
pub(super) const QUIET_S: f64 = 0.7;
/// Settling time of ramp, plate and demodulator, from the tone's start to the first frame that is judged, s.
const SETTLE_S: f64 = 0.3;
/// Lengths of the test, s.
const STOPS_FROM_S: f64 = 1.1;
const QUICK_S: f64 = 2.0;
const WHOLE_S: f64 = 10.7;

/// Silence before the tone that shows the loop delay, and timeout of the measurement, s. The timeout includes that of a field box's
/// first report, before which its e-stop counts as open.
pub(super) const DELAY_QUIET_S: f64 = 0.2;
const DELAY_S: f64 = 4.0;

/// Smallest level of the read-back tone, as a multiple of the silence.
const STANDS_OUT: f64 = 10.0;
/// Longest time for the exercise of the hardware stops, s.
const STOPS_S: f64 = 2.0;

/// Length of the excerpts that are examined sample by sample, and start of the silent one, s.
const EXCERPT_S: f64 = 0.2;
const SILENCE_FROM_S: f64 = 0.4;
/// End of the tone played with the amplifier off, s; its ramp and the loop delay end before the silence.
const RELAY_S: f64 = 0.15;

/// Measurements of the test.
#[derive(Debug, Default, Clone)]
pub(super) struct Measured {
    pub device: String,
    pub tone_v: f64,
    pub frames: Vec<ZmFrame>,
    pub tone_from_s: f64,
    /// Start of the exercise of the hardware stops; infinite before.
    pub tone_until_s: f64,
    /// Times of the hardware stops that were exercised.
    pub stops: Vec<StopTimes>,
    pub audio_s: f64,
    /// Audio and host clock at the first and the last batch, s.
    pub clocks_s: Option<[(f64, f64); 2]>,
    pub account: Account,
    pub force_n: Vec<(f64, f64)>,
    /// Force readings a second that the sensor says it sends.
    pub force_stated_hz: Option<f64>,
    pub corrupt: u64,
    /// State of the sensors' clocks.
    pub clocks: SensorClocks,
    pub positions: usize,
    /// Samples of all inputs in the silence and in the tone, interleaved; empty if the test ended earlier.
    pub silence: Vec<f32>,
    pub tone_samples: Vec<f32>,
    pub safety: SafetyState,
    pub estop_wired: bool,
    pub dead_man_wired: bool,
    pub heartbeat_wired: bool,
    pub enable_wired: bool,
    /// Whether a tone was played, with the amplifier on or off.
    pub driven: bool,
    /// Whether the hardware is simulated.
    pub simulated: bool,
    /// Scheduling of the time-critical threads.
    pub priorities: ThreadPriorities,
    /// Delay from a command to its read-back; `None` if the tone did not show it.
    pub loop_delay: Option<LoopDelay>,
    /// Unverified assumptions of the bench's safety; empty on simulated hardware.
    pub unverified: Vec<String>,
    /// Identification of the field box, once received.
    pub field_box: Option<String>,
    /// Reason why the calibration does not hold for the opened bench.
    pub calibration_fault: Option<String>,
}

impl Measured {
    /// Returns the settled frames of the tone alone.
    pub fn tone(&self) -> impl Iterator<Item = &ZmFrame> {
        let sounded = self.tone_from_s > 0.0;
        self.frames
            .iter()
            .filter(move |frame| sounded && frame.time_s >= self.tone_from_s)
            .take_while(|frame| frame.time_s < self.tone_until_s)
    }

    /// Returns the largest read-back while the amplifier was off and a tone was played, V peak; NaN without a frame, `None` if
    /// no enable line is wired.
    pub fn past_open_relay_v(&self) -> Option<f64> {
        let frames = self.frames.iter();
        let before = frames.take_while(|frame| frame.time_s < SILENCE_FROM_S);
        let most_v = before
            .map(|frame| frame.drive_v.norm())
            .fold(f64::NAN, f64::max);
        self.enable_wired.then_some(most_v)
    }

    /// Returns whether the tone was read back: it clearly exceeds the silence, independently of the gain of the read-back.
    pub fn tone_is_read_back(&self) -> bool {
        let level = |frames: &mut dyn Iterator<Item = &ZmFrame>| {
            frames.map(|frame| frame.drive_v.norm()).fold(0.0, f64::max)
        };
        let silence = |frame: &&ZmFrame| frame.time_s > SILENCE_FROM_S;
        level(&mut self.tone()) > STANDS_OUT * level(&mut self.quiet().filter(silence))
    }

    /// Returns the frames of the silence.
    pub fn quiet(&self) -> impl Iterator<Item = &ZmFrame> {
        self.frames.iter().filter(|frame| frame.time_s < QUIET_S)
    }
}

pub(super) fn measure(
    effective: &Effective,
    extent: &Extent,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> anyhow::Result<Measured> {
    let config = effective.config();
    let hardware = hardware()?;
    let lines = &hardware.lines;
    let (estop_wired, heartbeat_wired) = (lines.estop.is_some(), lines.heartbeat.is_some());
    let enable_wired = lines.enable.is_some();
    let simulated = hardware.simulated;
    let dead_man_wired = lines.dead_man.is_some();
    let tone_v = TONE_V.min(config.limits.drive_v);
    let tone = settings(config)?.admit(Waveform::Tone {
        carrier_hz: config.plate.resonance_hz,
        amplitude_v: tone_v,
    })?;
    let real = hardware.pace == Pace::Card;
    // The tone is too faint to be felt, and the dead-man switch is not yet held.
    let unheld = effective.clone().without_dead_man();
    let bench = Bench::open(&unheld, config.plate.resonance_hz, hardware)?;
    let unverified = bench.unverified(effective);
    let calibration_fault = bench
        .require_calibration_holds(effective)
        .err()
        .map(|error| anyhow::Error::from(error).root_cause().to_string());
    let (sender, receiver) = crossbeam_channel::bounded(1);
    let (excerpt_sender, excerpts) = crossbeam_channel::unbounded();
    let stop = bench.stop().clone();
    let field_box = bench.field_box.clone();
    let delay_only = *extent == Extent::Delay;
    let task = CheckTask {
        batches: bench.batches,
        recording: bench.recording,
        excerpts,
        excerpt_sender,
        requested_excerpts: 0,
        frames: (EXCERPT_S * f64::from(config.audio.rate_hz)) as usize,
        channels: config.audio.input_channels,
        drive: bench.drive,
        signals: bench.signals,
        gauges: bench.gauges,
        stop: stop.clone(),
        relay: (enable_wired && !delay_only).then_some(tone),
        quiet_s: if delay_only { DELAY_QUIET_S } else { QUIET_S },
        delay_only,
        relay_sounds: false,
        tone: Some(tone),
        test_s: match extent {
            Extent::Delay => DELAY_S,
            Extent::Stops => STOPS_FROM_S,
            Extent::Quick => QUICK_S,
            Extent::Whole { .. } => WHOLE_S,
        },
        began_ns: None,
        measured: Measured {
            device: bench.life.device(signalgen::StreamDirection::Input),
            estop_wired,
            dead_man_wired,
            heartbeat_wired,
            enable_wired,
            simulated,
            tone_v,
            tone_until_s: f64::INFINITY,
            calibration_fault,
            unverified: if real { unverified } else { Vec::new() },
            ..Measured::default()
        },
        sender,
    };
    let mut tasks = bench.first_tasks;
    tasks.push(Box::new(task));
    tasks.extend(bench.last_tasks);
    bench.life.run(tasks, || Ok(()))?;
    Ok(Measured {
        field_box: field_box.and_then(|field_box| field_box.in_words()),
        ..receiver.try_recv()?
    })
}

struct CheckTask {
    batches: Receiver<Batch>,
    recording: Sender<RecordingCommand>,
    excerpts: Receiver<Vec<f32>>,
    excerpt_sender: Sender<Vec<f32>>,
    /// Number of excerpts requested so far: the silence, then the tone.
    requested_excerpts: usize,
    frames: usize,
    channels: u16,
    drive: DriveControl,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    stop: StopFlag,
    /// Inaudible tone with the amplifier off, before the silence.
    relay: Option<signalgen::Program>,
    /// Whether that tone is playing.
    relay_sounds: bool,
    tone: Option<signalgen::Program>,
    /// Silence before the tone, s.
    quiet_s: f64,
    /// Whether the test ends once the loop delay is known, without exercising the stops.
    delay_only: bool,
    test_s: f64,
    /// Time of the first poll.
    began_ns: Option<u64>,
    measured: Measured,
    sender: Sender<Measured>,
}

/// Timeout for a card that never calls back, ns of the bench's clock: the simulated clock for a stepped bench.
const PATIENCE_NS: u64 = 30_000_000_000;

impl Task for CheckTask {
    fn name(&self) -> &'static str {
        "check"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let began_ns = *self.began_ns.get_or_insert(now_ns);
        let late = now_ns.saturating_sub(began_ns) > PATIENCE_NS;
        let measured = &mut self.measured;
        measured.safety = self.signals.state.get().unwrap_or_default();
        self.drive.poll(&measured.safety);
        for batch in self.batches.try_iter() {
            measured.audio_s = batch.audio_s;
            let clocks_s = (batch.audio_s, now_ns as f64 * 1e-9);
            measured.clocks_s = Some([
                measured.clocks_s.map_or(clocks_s, |[first, _]| first),
                clocks_s,
            ]);
            measured.account = batch.account;
            measured.frames.extend(batch.frames);
            measured
                .force_n
                .extend(batch.force.iter().map(|row| (row.normal_n, row.lateral_n)));
            measured.positions += batch.position.len();
        }
        let health = self.gauges.field.get().unwrap_or_default();
        (measured.corrupt, measured.force_stated_hz) =
            (health.force.corrupt, health.force_stated_hz);
        measured.clocks = self.gauges.sensor_clocks();
        if let Some(tone) = self.relay.take() {
            self.drive.sound_disarmed(tone);
            measured.driven = true;
            self.relay_sounds = true;
        }
        if self.relay_sounds && measured.audio_s >= RELAY_S {
            self.drive.stop();
            self.relay_sounds = false;
        }
        measured.loop_delay = self.signals.loop_delay.get();
        let lines = self.signals.lines.get().unwrap_or_default();
        let is_awaited = self.delay_only && lines.estop_open == Some(true);
        if measured.audio_s >= self.quiet_s
            && !is_awaited
            && let Some(tone) = self.tone.take()
        {
            measured.tone_from_s = measured.audio_s + SETTLE_S;
            self.drive.start(tone);
            measured.driven = true;
        }
        let due_s = [SILENCE_FROM_S, measured.tone_from_s.max(QUIET_S)];
        let sounding = self.tone.is_none();
        if let Some(&due_s) = due_s.get(self.requested_excerpts)
            && measured.audio_s >= due_s
            && (self.requested_excerpts == 0 || sounding)
        {
            self.requested_excerpts += 1;
            let sender = self.excerpt_sender.clone();
            let excerpt = Excerpt::next(self.frames, self.channels, sender);
            // The channel is closed only when the bench stops.
            let _ = self.recording.send(RecordingCommand::Excerpt(excerpt));
        }
        for samples in self.excerpts.try_iter() {
            if measured.silence.is_empty() {
                measured.silence = samples;
            } else {
                measured.tone_samples = samples;
            }
        }
        let tripped = matches!(measured.safety, SafetyState::Tripped { .. });
        if self.delay_only {
            if measured.loop_delay.is_some() || tripped || measured.audio_s >= self.test_s || late {
                self.stop.raise();
            }
            return Ok(());
        }
        if measured.audio_s >= self.test_s && measured.tone_until_s.is_infinite() {
            measured.tone_until_s = measured.audio_s;
            self.drive.exercise_stops();
        }
        let exercised = self.signals.stop_times.get();
        let is_over = exercised.is_some() || measured.audio_s >= self.test_s + STOPS_S;
        measured.stops = exercised.unwrap_or_default();
        if is_over || tripped || late {
            self.stop.raise();
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        self.measured.priorities = ThreadPriorities::now(&self.signals, &self.gauges);
        let _ = self.sender.send(self.measured.clone());
        Ok(())
    }
}
