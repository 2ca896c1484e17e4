//! The tasks of a bench against the simulated apparatus, in lock step.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use analysis::measurements::Measurements;
use config::{Config, Effective};
use devices::acquisition::RecordingCommand;
use devices::{Bench, Hardware};
use faults::RehearsedFault;
use jiff::Timestamp;
use mock_hw::apparatus::{Apparatus, ApparatusClock, ApparatusConfig};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use recorder::{Begin, RecorderNotice};
use recording::manifest::{EventKind, Manifest, RecordingEvent};
use recording::pipeline::Account;
use recording::writer::Ending;
use recording::{AudioFormat, RecordingReader};
use safety::{DriveReading, GpioError, InputLine, SafetyState, Signals, Trip, input, output};
use signalgen::{Program, Waveform};
use sources::{Lines, Place};
use tasks::{Clock, Schedule};

pub const RATE_HZ: u32 = 192_000;
pub const CHANNELS: u16 = 4;
/// Delay of the loop of the nominal bench, s.
pub const DELAY_S: f64 = 1e-4;

/// Returns the simulated bench's description with some of its lines changed.
pub fn config(changes: &[(&str, &str)]) -> Config {
    let mut text = config::rigs::MOCK_BENCH.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "no `{from}`");
        text = text.replacen(from, to, 1);
    }
    Config::parse(&text, "mock-bench.toml").unwrap()
}

pub fn apparatus(scenario: Scenario) -> Apparatus {
    rehearsing(scenario, &[])
}

/// Returns an apparatus with `faults` injected.
pub fn rehearsing(scenario: Scenario, faults: &[RehearsedFault]) -> Apparatus {
    let mut config = ApparatusConfig::new(scenario, 1, WorldPace::Stepped);
    config.faults = faults.to_vec();
    Apparatus::new(config).unwrap()
}

/// The apparatus's time as the host's clock.
struct HostClock(ApparatusClock);

impl Clock for HostClock {
    fn now_ns(&self) -> u64 {
        self.0.now_ns()
    }

    fn utc(&self) -> Timestamp {
        Timestamp::UNIX_EPOCH
    }
}

/// Returns the clock of a bench on `apparatus`.
pub fn clock(apparatus: &Apparatus) -> Arc<dyn Clock> {
    Arc::new(HostClock(apparatus.clock()))
}

/// Opens the bench of `config` on `apparatus`, with its streams playing; the test itself steps its tasks.
pub fn open(apparatus: &Apparatus, config: Config, lines: Lines) -> Bench {
    let hardware = hardware(apparatus, lines);
    let hardware = hardware
        .with_field_box(&config, apparatus.box_port())
        .unwrap();
    let bench = Bench::open(&Effective::uncalibrated(config), 35_000.0, hardware).unwrap();
    bench.life.streams().play().unwrap();
    bench
}

/// Returns the hardware of a bench on `apparatus`.
pub fn hardware(apparatus: &Apparatus, lines: Lines) -> Hardware {
    Hardware {
        cues: None,
        host: apparatus.host(),
        lines,
        force_place: match apparatus.force_address() {
            Some(address) => Some(Place::Address(address)),
            None if apparatus.force_is_on_card() => None,
            None => Some(Place::Port(apparatus.force_port().unwrap().to_owned())),
        },
        field_box: None,
        clock: clock(apparatus),
        schedule: Schedule::Threads,
        guard: Box::new(()),
        simulated: true,
        pace: safety::Pace::Simulated,
        keeps_accounts: false,
    }
}

/// Returns the command to record all inputs into `folder` at `rate_hz`.
pub fn begin(folder: &Path, rate_hz: u32, channels: u16) -> Begin {
    let text = r#"format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
channels.drive = { index = 0, volts_per_unit = 60.0 }
channels.pickup = { index = 1, metres_per_unit = 5e-6, phase_rad = 0.2 }
plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.0525 }
"#;
    Begin {
        folder: folder.to_owned(),
        manifest: Manifest::parse(text, "recording.toml").unwrap(),
        format: AudioFormat {
            sample_rate_hz: rate_hz,
            channels,
        },
    }
}

/// Kind, sample, frames and text of an event.
pub type Read = (EventKind, u64, Option<u64>, String);

/// Returns the events of a recording.
pub fn events(folder: &Path) -> Vec<Read> {
    let reader = RecordingReader::open(folder).unwrap();
    let events = reader.manifest().events.iter();
    events
        .map(|event: &RecordingEvent| {
            let text = event.text.clone().unwrap_or_default();
            (event.kind, event.sample, event.frames, text)
        })
        .collect()
}

/// Returns the samples of a recording, interleaved.
pub fn samples(folder: &Path) -> Vec<f32> {
    let wav = hound::WavReader::open(folder.join("signals.wav")).unwrap();
    wav.into_samples().map(Result::unwrap).collect()
}

/// Returns true times and amplitudes.
pub fn amplitudes(folder: &Path) -> Vec<(f64, f64)> {
    let series = std::fs::read_to_string(folder.join("truth.csv")).unwrap();
    let rows = series.lines().skip(1).map(|line| {
        let cell = |column| line.split(',').nth(column).unwrap().parse().unwrap();
        (cell(0), cell(13))
    });
    rows.collect()
}

/// Returns the time to rest, s, of a plate that is driven until `start_s`, in the `length_s` after it.
pub fn rest_s(truth: &[(f64, f64)], start_s: f64, length_s: f64) -> f64 {
    let driven = truth.iter().rfind(|(t_s, _)| *t_s < start_s).unwrap().1;
    assert!(driven > 0.5e-6, "{driven} m");
    let during = |&&(t_s, _): &&(f64, f64)| (start_s..start_s + length_s).contains(&t_s);
    let moving = |&&(_, amplitude): &&(f64, f64)| amplitude > 0.01 * driven;
    let last = truth.iter().filter(during).rfind(moving);
    last.map_or(0.0, |(t_s, _)| t_s - start_s)
}

/// Returns a tone of 10 V.
pub fn tone() -> Program {
    let settings = devices::drive_control::settings(&config(&[])).unwrap();
    let tone = Waveform::Tone {
        carrier_hz: 35_000.0,
        amplitude_v: 10.0,
    };
    settings.admit(tone).unwrap()
}

/// A line with a level set by the test.
#[derive(Default)]
pub struct Level(pub Arc<AtomicBool>);

impl InputLine for Level {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        Ok(self.0.load(Ordering::Relaxed))
    }
}

/// Changes to the read-back before the watch reads it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tamper {
    Nothing,
    /// The gain changes by this factor.
    Gain(f64),
    /// Another source drives the plate, V.
    Alive(f64),
}

impl Tamper {
    /// Changes the newest reading, once.
    pub fn apply(self, signals: &Signals, tampered: &mut u64) {
        let Some(reading) = signals.readback.get() else {
            return;
        };
        if self == Self::Nothing || reading.sample == *tampered {
            return;
        }
        *tampered = reading.sample;
        let volts = match self {
            Self::Gain(gain) => gain * reading.volts,
            Self::Alive(volts) => reading.volts.max(volts),
            Self::Nothing => reading.volts,
        };
        signals.readback.set(DriveReading { volts, ..reading });
    }
}

pub struct Rig {
    pub apparatus: Apparatus,
    pub bench: Bench,
    pub record: Measurements,
    pub account: Account,
    pub warnings: Vec<String>,
    ticks: u64,
    disk_stalls: bool,
    watch_hangs: bool,
    rate_hz: u32,
    channels: u16,
    task_delay: (u64, u64),
    temp: tempfile::TempDir,
}

impl Rig {
    /// Returns a plate that is driven with 10 V, watched as on a real bench.
    pub fn driven() -> Self {
        let mut config = config(&[("silence_s = 0.25", "silence_s = 0.05")]);
        config.safety.measured_delay_s = Some(DELAY_S);
        let mut rig = Self::new(Scenario::default(), config, None);
        rig.drive();
        rig
    }

    /// Returns a plate at rest; `encoder` replaces the apparatus's own.
    pub fn new(
        scenario: Scenario,
        config: Config,
        encoder: Option<[Box<dyn InputLine>; 2]>,
    ) -> Self {
        Self::with_apparatus(apparatus(scenario), config, encoder)
    }

    /// Returns a plate of `apparatus` at rest.
    pub fn with_apparatus(
        apparatus: Apparatus,
        config: Config,
        encoder: Option<[Box<dyn InputLine>; 2]>,
    ) -> Self {
        let lines = Lines {
            encoder,
            ..Lines::default()
        };
        Self::with_lines(apparatus, config, lines)
    }

    /// Returns a plate of `apparatus` at rest, with `lines` in addition to the lines that stop it.
    pub fn with_lines(mut apparatus: Apparatus, config: Config, lines: Lines) -> Self {
        let pins = apparatus.pins().unwrap();
        let lines = Lines {
            estop: Some(input("e-stop", pins.estop)),
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(output("heartbeat", pins.heartbeat)),
            ..lines
        };
        let rate_hz = config.audio.rate_hz;
        let channels = config.audio.input_channels;
        let bench = open(&apparatus, config, lines);
        Self {
            apparatus,
            bench,
            record: Measurements::default(),
            account: Account::default(),
            warnings: Vec::new(),
            ticks: 0,
            disk_stalls: false,
            watch_hangs: false,
            rate_hz,
            channels,
            task_delay: (u64::MAX, 0),
            temp: tempfile::tempdir().unwrap(),
        }
    }

    pub fn drive(&mut self) {
        self.bench.drive.start(tone());
    }

    /// Lets time pass and requires that no trip occurs.
    pub fn pass(&mut self, seconds: f64) {
        let until_ns = self.apparatus.now_ns() + (seconds * 1e9) as u64;
        while self.apparatus.now_ns() < until_ns {
            let safety = self.tick();
            assert!(!matches!(safety, SafetyState::Tripped { .. }), "{safety:?}");
        }
    }

    /// Steps the apparatus and every task; all must succeed.
    pub fn tick(&mut self) -> SafetyState {
        self.try_tick().unwrap()
    }

    /// Steps the apparatus and every task, up to the first that fails.
    pub fn try_tick(&mut self) -> anyhow::Result<SafetyState> {
        self.apparatus.step().unwrap();
        self.ticks += 1;
        let (period_ticks, delay_ns) = self.task_delay;
        let stale_ns = if self.ticks.is_multiple_of(period_ticks) {
            delay_ns
        } else {
            0
        };
        let now_ns = self.apparatus.now_ns() - stale_ns;
        let Bench {
            first_tasks,
            last_tasks,
            ..
        } = &mut self.bench;
        for task in first_tasks.iter_mut().chain(last_tasks) {
            let hangs = self.disk_stalls && task.name() == "recorder"
                || self.watch_hangs && task.name() == "safety";
            if !hangs {
                task.poll(now_ns)?;
            }
        }
        let safety = self.bench.signals.state.get().unwrap_or_default();
        self.bench.drive.poll(&safety);
        for batch in self.bench.batches.try_iter() {
            self.account = batch.account;
            self.warnings.extend(batch.warnings.iter().cloned());
            self.record.take(batch);
        }
        Ok(safety)
    }

    /// Requires a stop that passes `told` within `within_s`, then silence, and that a new drive request starts nothing
    /// for `latched_s`.
    pub fn stops(
        &mut self,
        name: &str,
        is_expected: fn(&Trip) -> bool,
        within_s: f64,
        latched_s: f64,
    ) {
        let fault_ns = self.apparatus.now_ns();
        let since_s = |rig: &Self| (rig.apparatus.now_ns() - fault_ns) as f64 * 1e-9;
        let trip = loop {
            if let SafetyState::Tripped { trip } = self.tick() {
                break trip;
            }
            assert!(since_s(self) < within_s, "{name}: not within {within_s} s");
        };
        assert!(is_expected(&trip), "{name}: {trip}");
        let tripped_s = since_s(self);
        while self.bench.drive.sounds() {
            self.tick();
            assert!(since_s(self) < tripped_s + 0.02, "{name}: sounds on");
        }
        self.drive();
        while since_s(self) < tripped_s + latched_s {
            assert!(matches!(self.tick(), SafetyState::Tripped { .. }), "{name}");
        }
    }

    /// Requires a driven plate to stop within 0.1 s of a fault, and the recording up to then to be kept.
    pub fn stops_recorded(
        &mut self,
        name: &str,
        inject: fn(&Self),
        is_expected: fn(&Trip) -> bool,
    ) {
        self.drive();
        self.pass(0.5);
        let folder = self.begin("kept");
        self.pass(0.3);
        assert!(self.bench.drive.sounds(), "{name}");
        inject(self);
        self.stops(name, is_expected, 0.1, 0.3);
        self.end();
        let reader = RecordingReader::open(&folder).unwrap();
        let kept_s = reader.frames() as f64 / f64::from(reader.format().sample_rate_hz);
        assert!(kept_s > 0.29, "{name}: {kept_s} s kept");
    }

    /// Lets time pass for the apparatus only: the program is frozen.
    pub fn freeze(&mut self, seconds: f64) {
        let until_ns = self.apparatus.now_ns() + (seconds * 1e9) as u64;
        while self.apparatus.now_ns() < until_ns {
            self.apparatus.step().unwrap();
        }
    }

    /// Holds up all tasks for `by_ns` at every `every`th tick, between reading the clock and everything else.
    pub fn hold_up(&mut self, period_ticks: u64, delay_ns: u64) {
        self.task_delay = (period_ticks, delay_ns);
    }

    /// Sets whether the recorder waits for its disk.
    pub fn stall_disk(&mut self, stalls: bool) {
        self.disk_stalls = stalls;
    }

    /// Sets whether the safety watch hangs.
    pub fn hang_watch(&mut self, hangs: bool) {
        self.watch_hangs = hangs;
    }

    /// Begins a recording.
    pub fn begin(&mut self, name: &str) -> PathBuf {
        let folder = self.temp.path().join(name);
        let begin = RecordingCommand::Begin(Box::new(begin(&folder, self.rate_hz, self.channels)));
        self.bench.recording.send(begin).unwrap();
        folder
    }

    /// Ends the recording and waits until it is saved, in any state of the bench.
    pub fn end(&mut self) {
        let end = RecordingCommand::End(Ending::Completed);
        self.bench.recording.send(end).unwrap();
        let until_ns = self.apparatus.now_ns() + 10_000_000;
        while self.apparatus.now_ns() < until_ns {
            self.tick();
        }
        self.saved();
    }

    /// Ends the recording and the tasks as a program does after one of its tasks failed.
    pub fn close(&mut self) {
        let reason = "a task failed".to_owned();
        let end = RecordingCommand::End(Ending::Interrupted { reason });
        self.bench.recording.send(end).unwrap();
        let Bench {
            first_tasks,
            last_tasks,
            ..
        } = &mut self.bench;
        first_tasks
            .iter_mut()
            .chain(&mut *last_tasks)
            .for_each(|task| task.stop());
        for task in first_tasks.iter_mut().chain(last_tasks) {
            task.finish().unwrap();
        }
        self.saved();
    }

    fn saved(&self) {
        let saved = |notice| matches!(notice, RecorderNotice::Saved { .. });
        assert!(self.bench.notices.try_iter().any(saved), "not saved");
    }
}
