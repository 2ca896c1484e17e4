//! Puts a bench together from its hardware: streams opened, tasks wired, nothing driven yet.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use crossbeam_channel::{Receiver, Sender};
use impedance::{Channels, Demodulator, Filter, Input, OUTPUT_RATE_HZ, PlateConstants, Zm};
use signalgen::audio::{Duplex, DuplexConfig, Host, StreamChoice, Streams};
use signalgen::{Generator, InputReader, KillSwitch, StreamDirection, StreamHealth};

use crate::acquisition::{Acquisition, RecordingCommand, Wiring};
use crate::calibration::operator::Request;
use crate::claim::Claim;
use crate::clock::Clock;
use crate::config::{Config, SampleFormat};
use crate::drive::{Drive, Guard, settings};
use crate::field::{Encoder, Field, Reading};
use crate::force::{ForceLink, open_port};
use crate::gap::LossWatch;
use crate::gpio::Lines;
use crate::pipeline::{Batch, Pipeline};
use crate::recording::recorder::{RecorderGauge, RecorderNotice, RecorderTask, recorder};
use crate::safety::{Safety, SafetyLimits, SafetyLines};
use crate::schedule::{Schedule, StopFlag, Task};
use crate::session::Watcher;
use crate::shared::Shared;

/// What the composition root found or simulated.
pub struct Hardware {
    /// Sound layer.
    pub host: Host,
    /// Digital lines.
    pub lines: Lines,
    /// The force sensor's port, where it is not the configuration's.
    pub force_port: Option<PathBuf>,
    /// The simulated vibrometer's port: where known amplitudes come from when nothing else is said.
    pub vibrometer_port: Option<PathBuf>,
    /// Time.
    pub clock: Arc<dyn Clock>,
    /// Who runs when.
    pub schedule: Schedule,
    /// Who else sees and hears what the participant does.
    pub watchers: Vec<Watcher>,
    /// Does what a calibration asks of its operator; `None` where that takes a person.
    pub hands: Option<Hands>,
    /// Keeps other instances away; `None` where each has an apparatus of its own.
    pub claim: Option<Claim>,
    /// For screens and files: none of this is real.
    pub simulated: bool,
}

/// Does what is asked, at once.
pub type Hands = Box<dyn FnMut(&Request) + Send>;

/// The parts of an opened bench that commands work with; its tasks are ready to be scheduled.
pub struct Bench {
    /// Closed when dropped.
    pub streams: Streams,
    /// Counters of the card.
    pub health: StreamHealth,
    /// Starts and stops the drive.
    pub drive: Drive,
    /// Stops it from anywhere.
    pub kill: KillSwitch,
    /// Acquired data.
    pub batches: Receiver<Batch>,
    /// Commands to the recording.
    pub recording: Sender<RecordingCommand>,
    /// Answers of the recorder.
    pub notices: Receiver<RecorderNotice>,
    /// State of the recorder.
    pub gauge: RecorderGauge,
    /// The participant's button; `None` when none is wired.
    pub button: Option<Arc<AtomicBool>>,
    /// Whether positions will come.
    pub has_position: bool,
    /// Latest values.
    pub shared: Arc<Shared>,
    /// Safety watch and slow inputs: they run before whoever decides.
    pub before: Vec<Box<dyn Task>>,
    /// Acquisition and recorder: they run after.
    pub after: Vec<Box<dyn Task>>,
    /// Ends everything.
    pub stop: StopFlag,
}

/// Streams, sensors and safety watch of a bench, opened; who reads the samples is still open.
pub struct OpenHardware {
    /// Closed when dropped.
    pub streams: Streams,
    /// Counters of the card.
    pub health: StreamHealth,
    /// Samples.
    pub input: InputReader,
    /// Starts and stops the drive.
    pub drive: Drive,
    /// Stops it from anywhere.
    pub kill: KillSwitch,
    /// Of the slow inputs.
    pub readings: Receiver<Reading>,
    /// The participant's button; `None` when none is wired.
    pub button: Option<Arc<AtomicBool>>,
    /// Whether positions will come.
    pub has_position: bool,
    /// Latest values; whoever reads the samples publishes the drive's read-back there.
    pub shared: Arc<Shared>,
    /// Safety watch and slow inputs: they run before whoever decides.
    pub tasks: Vec<Box<dyn Task>>,
}

impl OpenHardware {
    /// Opens the streams and the sensors.
    ///
    /// # Errors
    /// Names the part that is missing, busy or unable, and what to do.
    pub fn open(
        config: &Config,
        host: &Host,
        lines: Lines,
        force_port: Option<PathBuf>,
        clock: &Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        let drive_settings = settings(config)?;
        let Duplex {
            streams,
            drive,
            input,
            health,
        } = signalgen::audio::open_duplex(host, &duplex(config), Generator::new(drive_settings))?;
        let shared = Arc::new(Shared::default());
        let (safety_commands, safety_orders) = crossbeam_channel::unbounded();
        let (readings, waiting_readings) = crossbeam_channel::unbounded();
        let force = force_link(config, force_port)?;
        let expects_force = force.is_some();
        let encoder = lines
            .encoder
            .zip(config.encoder.as_ref())
            .map(|(lines, encoder)| {
                Encoder::new(lines, encoder.metres_per_count, encoder.origin_m)
            });
        let has_position = encoder.is_some();
        let pressed = Arc::new(AtomicBool::new(false));
        let button = lines.button.is_some().then(|| pressed.clone());
        let field = Field::new(
            force,
            encoder,
            lines.button,
            readings,
            pressed,
            shared.clone(),
            safety_commands.clone(),
            clock.clone(),
        );
        let kill = drive.kill_switch();
        let safety = Safety::new(
            limits(config),
            SafetyLines {
                estop: lines.estop,
                enable: lines.enable,
                heartbeat: lines.heartbeat,
            },
            Box::new(Guard::new(&drive, health.clone())),
            expects_force,
            shared.clone(),
            safety_orders,
        );
        Ok(Self {
            streams,
            health,
            input,
            drive: Drive::new(drive, safety_commands),
            kill,
            readings: waiting_readings,
            button,
            has_position,
            shared,
            tasks: vec![Box::new(safety), Box::new(field)],
        })
    }
}

/// Audio that may wait for the disk, s (DESIGN.md, FAULTS.md row 27).
const RECORDER_QUEUE_S: f64 = 10.0;
/// Messages to the recorder for each block of audio, at most.
const MESSAGES_PER_BLOCK: f64 = 3.0;
/// Messages to the recorder of forces and positions, which come by the field's polls whatever the block, per second at most.
const FIELD_MESSAGES_PER_S: f64 = 2000.0;

impl Bench {
    /// Opens the streams and the sensors and wires the tasks.
    ///
    /// # Errors
    /// Names the part that is missing, busy or unable, and what to do.
    pub fn open(
        config: &Config,
        carrier_hz: f64,
        host: &Host,
        lines: Lines,
        force_port: Option<PathBuf>,
        clock: &Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        let (filter, zm) = impedance_chain(config, carrier_hz)?;
        let OpenHardware {
            streams,
            health,
            input,
            drive,
            kill,
            readings,
            button,
            has_position,
            shared,
            tasks: before,
        } = OpenHardware::open(config, host, lines, force_port, clock)?;
        let clipping = |index: u16, clip_units: f64| Input {
            channel: usize::from(index),
            clip_level: clip_units as f32,
        };
        let (on_drive, on_pickup) = (&config.channels.drive, &config.channels.pickup);
        let channels = usize::from(config.audio.input_channels);
        let demodulator = Demodulator::drive_and_pickup(
            filter,
            channels,
            clipping(on_drive.index, on_drive.clip_units),
            clipping(on_pickup.index, on_pickup.clip_units),
        )?;
        let (recording, recording_orders) = crossbeam_channel::unbounded();
        let (batches, acquired) = crossbeam_channel::unbounded();
        let block_frames = f64::from(
            streams
                .buffer_frames(StreamDirection::Input)
                .unwrap_or(FEWEST_BLOCK_FRAMES),
        );
        let blocks_per_s = f64::from(config.audio.rate_hz) / block_frames;
        let messages_per_s = blocks_per_s * MESSAGES_PER_BLOCK + FIELD_MESSAGES_PER_S;
        let (sender, notices, recorder) = recorder((RECORDER_QUEUE_S * messages_per_s) as usize);
        let gauge = sender.gauge();
        let acquisition = Acquisition::new(
            input,
            Pipeline::new(demodulator, zm, channels),
            LossWatch::new(
                carrier_hz,
                config.audio.rate_hz,
                channels,
                usize::from(config.channels.drive.index),
            ),
            Wiring {
                readings,
                commands: recording_orders,
                recorder: sender,
                batches,
            },
            shared.clone(),
            clock.clone(),
        );
        Ok(Self {
            streams,
            health,
            drive,
            kill,
            batches: acquired,
            recording,
            notices,
            gauge,
            button,
            has_position,
            shared,
            before,
            after: vec![Box::new(acquisition), Box::new(Recorder(recorder))],
            stop: StopFlag::default(),
        })
    }
}

/// Blocks of a card that does not say how long they are.
const FEWEST_BLOCK_FRAMES: u32 = 32;

/// The demodulation filter at the carrier, and the impedance by the constants in force.
///
/// # Errors
/// When rate and carrier do not go together.
pub fn impedance_chain(config: &Config, carrier_hz: f64) -> anyhow::Result<(Filter, Zm)> {
    let filter = Filter::new(impedance::Settings {
        sample_rate_hz: config.audio.rate_hz,
        carrier_hz,
        output_rate_hz: OUTPUT_RATE_HZ,
    })?;
    let plate = PlateConstants {
        resonance_hz: config.plate.resonance_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
    };
    let channels = Channels {
        drive_volts_per_unit: config.channels.drive.volts_per_unit,
        pickup_metres_per_unit: config.channels.pickup.metres_per_unit,
        pickup_phase_rad: config.channels.pickup.phase_rad,
    };
    let zm = Zm::new(plate, channels, &filter)?;
    Ok((filter, zm))
}

fn duplex(config: &Config) -> DuplexConfig {
    let audio = &config.audio;
    let format = match audio.sample_format {
        SampleFormat::F32 => signalgen::SampleFormat::F32,
        SampleFormat::I32 => signalgen::SampleFormat::I32,
        SampleFormat::I24 => signalgen::SampleFormat::I24,
        SampleFormat::I16 => signalgen::SampleFormat::I16,
    };
    let stream = |device: &str, channels| StreamChoice {
        device: device.to_owned(),
        channels,
        format,
    };
    DuplexConfig {
        sample_rate_hz: audio.rate_hz,
        output: stream(&audio.output_device, audio.output_channels),
        drive_channel: config.output.channel,
        input: stream(&audio.input_device, audio.input_channels),
        buffer_frames: audio.buffer_frames,
        ring_s: audio.ring_s,
    }
}

fn force_link(config: &Config, port: Option<PathBuf>) -> anyhow::Result<Option<ForceLink>> {
    let Some(force) = &config.force else {
        return Ok(None);
    };
    let path = port.as_ref().unwrap_or(&force.port);
    let port = open_port(path, force.baud).context("the force sensor")?;
    Ok(Some(ForceLink::new(
        port,
        force.protocol,
        force.latency_s,
        force.correction(),
    )))
}

fn limits(config: &Config) -> SafetyLimits {
    let ns = |seconds: f64| (seconds * 1e9) as u64;
    let safety = &config.safety;
    SafetyLimits {
        max_normal_n: safety.max_normal_n,
        max_lateral_n: safety.max_lateral_n,
        readback_tolerance: safety.readback_tolerance,
        readback_floor_v: safety.readback_floor_v,
        loop_latency_ns: ns(safety.loop_latency_s),
        rate_hz: f64::from(config.audio.rate_hz),
        silence_ns: ns(safety.silence_s),
    }
}

/// The recorder as a task.
struct Recorder(RecorderTask);

impl Task for Recorder {
    fn name(&self) -> &'static str {
        "recorder"
    }

    fn period(&self) -> std::time::Duration {
        std::time::Duration::from_millis(5)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        // What is due on disk is due in real time, also when the apparatus runs ahead of it.
        self.0.poll(std::time::Instant::now());
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.0.poll(std::time::Instant::now());
        Ok(())
    }
}
