//! Assembly of a bench from its hardware: opens the streams and wires the tasks, without driving the plate yet.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use config::{CalibrationError, Config, Effective, EncoderSource, GpioBackend, SampleFormat};
use crossbeam_channel::{Receiver, Sender};
use recorder::{RecorderGauge, RecorderNotice, RecorderTask, recorder};
use recording::pipeline::{Batch, Pipeline};
use safety::{Pace, SafetyLines, Signals, Watch};
use signalgen::audio::{Duplex, DuplexConfig, Host, StreamChoice};
use signalgen::{Generator, InputReader, StreamDirection};
use sources::field_box::FieldBoxDevice;
use sources::position::LineEncoder;
use sources::{Lines, Place};
use tasks::{Clock, Mailbox, Schedule, StopFlag, Task};

use crate::acquisition::{Acquisition, AcquisitionQueues, RecordingCommand};
use crate::arming::safety_limits;
use crate::batch_queue::batch_queue;
use crate::boot::Boot;
use crate::device_nodes::sound_card;
use crate::drive_control::{DriveControl, WatchedDrive, settings};
use crate::drive_ledger::DriveLedger;
use crate::encoder::PositionEncoder;
use crate::field_task::{Field, FieldReading};
use crate::gauges::DeviceReadings;
use crate::life::Life;
use crate::lost_frames::LossWatch;
use crate::output_gap::OutputGapWatch;
use crate::plate_warmth::WarmthError;
use crate::reading_queue::reading_queue;
use crate::thread_priority::{lock_memory, thread_start};
use crate::tuning::Tuning;

/// Hardware of a bench, found or simulated by the composition root.
pub struct Hardware {
    /// Sound layer.
    pub host: Host,
    /// Sound layer of the participant's cues; `None` for that of the streams.
    pub cues: Option<Host>,
    /// Digital lines.
    pub lines: Lines,
    /// Place of the force sensor; `None` for the configured place.
    pub force_place: Option<Place>,
    /// The field box; `None` if no source of the bench is behind one.
    pub field_box: Option<FieldBoxDevice>,
    /// Clock of the host.
    pub clock: Arc<dyn Clock>,
    /// Schedule of the tasks.
    pub schedule: Schedule,
    /// Dropped after the streams are closed: the claim that keeps other instances away, or a simulated apparatus.
    pub guard: Box<dyn Send>,
    /// Whether the hardware is simulated, as shown on screens and in files.
    pub simulated: bool,
    /// Source of the sound card's time.
    pub pace: Pace,
    /// Whether driving time and plate temperature are kept after the program ends; not in simulated time.
    pub keeps_accounts: bool,
}

impl Hardware {
    /// Opens the field box of `config`, or the one at `simulated_port`, and takes the lines behind it. A real box must
    /// answer; a simulated one may need time to pass first.
    ///
    /// # Errors
    /// If its port is missing, busy or forbidden, or the device there is not a usable field box.
    pub fn with_field_box(
        mut self,
        config: &Config,
        simulated_port: Option<&Path>,
    ) -> anyhow::Result<Self> {
        self.field_box = FieldBoxDevice::open(config, simulated_port, Arc::clone(&self.clock))?;
        if let Some(field_box) = self.field_box.as_ref().filter(|_| !self.simulated) {
            field_box.require_known()?;
        }
        if let (GpioBackend::FieldBox, Some(field_box)) = (config.gpio.backend, &self.field_box) {
            self.lines = field_box.lines();
        }
        Ok(self)
    }
}

/// Opened streams, sensors and safety watch of a bench, without a reader of the samples.
pub struct OpenHardware {
    /// Streams, clock and schedule; [`Life::run`] starts the bench.
    pub life: Life,
    /// Samples from the sound card.
    pub input: InputReader,
    /// Starts and stops the drive.
    pub drive: DriveControl,
    /// Readings of the slow inputs.
    pub readings: Receiver<FieldReading>,
    /// The participant's button; `None` if it is not wired.
    pub button: Option<Arc<AtomicBool>>,
    /// Whether an encoder is wired.
    pub has_position: bool,
    /// The field box, if there is one.
    pub field_box: Option<FieldBoxDevice>,
    /// Values that the safety watch judges; the reader of the samples publishes the drive's read-back there.
    pub signals: Arc<Signals>,
    /// Gauges for screens.
    pub gauges: Arc<DeviceReadings>,
    /// Safety watch and slow inputs: they run before the tasks that decide.
    pub tasks: Vec<Box<dyn Task>>,
}

impl OpenHardware {
    /// Opens the streams and the sensors, and makes the drive safe against panics and signals.
    ///
    /// # Errors
    /// Names the part that is missing, busy or unsuitable, and the remedy.
    pub fn open(bench: &Effective, hardware: Hardware) -> anyhow::Result<Self> {
        let config = bench.config();
        let Hardware {
            host,
            cues,
            lines,
            force_place,
            field_box,
            clock,
            schedule,
            guard,
            simulated,
            pace,
            keeps_accounts: _,
        } = hardware;
        let drive_settings = settings(config)?;
        lock_memory(config, &schedule)?;
        let signals = Arc::new(Signals::default());
        let gauges = Arc::new(DeviceReadings {
            lines: Arc::clone(&signals.lines),
            losses: Arc::clone(&signals.losses),
            ..DeviceReadings::default()
        });
        let start = thread_start(config, simulated, &gauges);
        let generator = Generator::new(drive_settings);
        let Duplex {
            streams,
            drive,
            input,
            tap,
            health,
        } = signalgen::audio::open_duplex(&host, &duplex(config), generator, start.as_ref())?;
        let safety_commands = Mailbox::default();
        let (readings, waiting_readings) = reading_queue();
        let force = sources::open(config, force_place, tap, field_box.as_ref())
            .context("the force sensor")?;
        let expects_force = force.is_some();
        let encoder = config.encoder.as_ref().and_then(|encoder| {
            let source = match encoder.source {
                EncoderSource::FieldBox => field_box.as_ref()?.encoder(),
                EncoderSource::Nidaqmx => lines.counter?,
                EncoderSource::Gpio => Box::new(LineEncoder::new(lines.encoder?)),
            };
            let (step_m, origin_m) = (encoder.metres_per_count, encoder.origin_m);
            Some(PositionEncoder::new(source, step_m, origin_m))
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
            signals.clone(),
            gauges.clone(),
            safety_commands.clone(),
            clock.clone(),
        );
        let limits = safety_limits(config, pace);
        let absence_s = limits.longest_absence_ns() as f64 * 1e-9;
        let absence_frames = (absence_s * f64::from(config.audio.rate_hz)) as u64;
        let watch = Watch::new(
            limits,
            SafetyLines {
                estop: lines.estop,
                dead_man: lines.dead_man,
                enable: lines.enable,
                heartbeat: lines.heartbeat,
            },
            Box::new(WatchedDrive::new(&drive, health, absence_frames)),
            expects_force,
            signals.clone(),
            safety_commands.clone(),
        );
        let kill = drive.kill_switch();
        let drive = DriveControl::new(drive, safety_commands, Arc::clone(&signals));
        let life = Life::begin(
            cues.unwrap_or(host),
            streams,
            (kill, drive.stop_switch()),
            clock,
            schedule,
            guard,
        )?;
        Ok(Self {
            life,
            input,
            drive,
            readings: waiting_readings,
            button,
            has_position,
            field_box,
            signals,
            gauges,
            tasks: vec![Box::new(watch), Box::new(field)],
        })
    }
}

impl OpenHardware {
    /// Counts driving time and plate temperature in `ledger`, as of this moment of the computer's run.
    ///
    /// # Errors
    /// [`WarmthError`] if the plate's temperature cannot be written.
    pub fn charge(&mut self, ledger: DriveLedger, boot: Boot) -> Result<(), WarmthError> {
        let keepers = ledger.begin(&self.drive, self.life.clock(), boot, &self.signals)?;
        self.tasks.extend(keepers);
        Ok(())
    }
}

/// The parts of an opened bench that commands work with; its tasks are ready to be scheduled.
pub struct Bench {
    /// Streams, clock and schedule; [`Life::run`] starts the bench.
    pub life: Life,
    /// Starts and stops the drive.
    pub drive: DriveControl,
    /// Acquired data.
    pub batches: Receiver<Batch>,
    /// Commands to the recording.
    pub recording: Sender<RecordingCommand>,
    /// Notices from the recorder.
    pub notices: Receiver<RecorderNotice>,
    /// Fill and faults of the recorder's queue.
    pub gauge: RecorderGauge,
    /// The participant's button; `None` if it is not wired.
    pub button: Option<Arc<AtomicBool>>,
    /// Whether an encoder is wired.
    pub has_position: bool,
    /// The field box, if there is one.
    pub field_box: Option<FieldBoxDevice>,
    /// Values that the safety watch judges.
    pub signals: Arc<Signals>,
    /// Gauges for screens.
    pub gauges: Arc<DeviceReadings>,
    /// Safety watch and slow inputs: they run before the tasks that decide.
    pub first_tasks: Vec<Box<dyn Task>>,
    /// Acquisition and recorder: they run after the tasks that decide.
    pub last_tasks: Vec<Box<dyn Task>>,
}

/// Length of the audio that may wait for the disk, s (DESIGN.md, FAULTS.md row 27).
const RECORDER_QUEUE_S: f64 = 10.0;
/// Most messages to the recorder for each block of audio.
const MESSAGES_PER_BLOCK: f64 = 3.0;
/// Most messages with forces and positions to the recorder per second, for any length of a block.
const FIELD_MESSAGES_PER_S: f64 = 2000.0;

impl Bench {
    /// Opens the streams and the sensors and wires the tasks.
    ///
    /// # Errors
    /// Names the part that is missing, busy or unsuitable, and the remedy.
    pub fn open(bench: &Effective, carrier_hz: f64, hardware: Hardware) -> anyhow::Result<Self> {
        let config = bench.config();
        let tuning = Tuning::new(config, carrier_hz)?;
        let OpenHardware {
            life,
            input,
            drive,
            readings,
            button,
            has_position,
            field_box,
            signals,
            gauges,
            tasks: first_tasks,
        } = OpenHardware::open(bench, hardware)?;
        let channels = usize::from(config.audio.input_channels);
        let drive_channel = usize::from(config.channels.drive.index);
        let (recording, recording_orders) = crossbeam_channel::unbounded();
        let (batches, acquired) = batch_queue();
        let block_frames = f64::from(
            life.streams()
                .buffer_frames(StreamDirection::Input)
                .unwrap_or(FEWEST_BLOCK_FRAMES),
        );
        let blocks_per_s = f64::from(config.audio.rate_hz) / block_frames;
        let messages_per_s = blocks_per_s * MESSAGES_PER_BLOCK + FIELD_MESSAGES_PER_S;
        let (sender, notices, recorder) = recorder((RECORDER_QUEUE_S * messages_per_s) as usize);
        let gauge = sender.gauge();
        let acquisition = Acquisition::new(
            input,
            Pipeline::new(tuning.demodulator, tuning.zm, channels),
            (
                LossWatch::new(carrier_hz, config.audio.rate_hz, channels, drive_channel),
                OutputGapWatch::new(carrier_hz, config.audio.rate_hz, channels, drive_channel),
            ),
            AcquisitionQueues {
                readings,
                commands: recording_orders,
                recorder: sender,
                batches,
            },
            signals.clone(),
            gauges.clone(),
            life.clock().clone(),
        );
        Ok(Self {
            life,
            drive,
            batches: acquired,
            recording,
            notices,
            gauge,
            button,
            has_position,
            field_box,
            signals,
            gauges,
            first_tasks,
            last_tasks: vec![Box::new(acquisition), Box::new(Recorder(recorder))],
        })
    }

    /// Counts driving time and plate temperature in `ledger`, as of this moment of the computer's run.
    ///
    /// # Errors
    /// [`WarmthError`] if the plate's temperature cannot be written.
    pub fn charge(&mut self, ledger: DriveLedger, boot: Boot) -> Result<(), WarmthError> {
        let keepers = ledger.begin(&self.drive, self.life.clock(), boot, &self.signals)?;
        self.first_tasks.extend(keepers);
        Ok(())
    }

    /// Requires that the calibration in force was measured on this opened bench and has not expired.
    ///
    /// # Errors
    /// As [`Effective::require_calibration_holds`].
    pub fn require_calibration_holds(&self, bench: &Effective) -> Result<(), CalibrationError> {
        bench.require_calibration_holds(
            self.life.device(StreamDirection::Input),
            self.life.device(StreamDirection::Output),
            sound_card(bench.config()),
            (self.life.clock().utc(), self.life.clock().is_simulated()),
        )
    }

    /// Returns the quantities that this bench's safety depends on and that have not been measured, as
    /// [`Effective::unverified`].
    #[must_use]
    pub fn unverified(&self, bench: &Effective) -> Vec<String> {
        bench.unverified(self.life.clock().utc())
    }

    /// Returns the flag that ends the bench.
    #[must_use]
    pub fn stop(&self) -> &StopFlag {
        self.life.stop()
    }
}

/// Assumed block length of a card that does not state it, frames: the shortest.
const FEWEST_BLOCK_FRAMES: u32 = 32;

fn duplex(config: &Config) -> DuplexConfig {
    let audio = &config.audio;
    let format = match audio.sample_format {
        SampleFormat::F32 => signalgen::StreamFormat::F32,
        SampleFormat::I32 => signalgen::StreamFormat::I32,
        SampleFormat::I24 => signalgen::StreamFormat::I24,
        SampleFormat::I16 => signalgen::StreamFormat::I16,
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
        tap: sources::tapped(config),
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
        // Disk deadlines are in real time, also when a simulated apparatus runs ahead of it.
        self.0.poll(std::time::Instant::now());
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.0.finish(std::time::Instant::now());
        Ok(())
    }
}
