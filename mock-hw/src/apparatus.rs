//! The whole simulated apparatus: plate, person and sensors behind a sound card, a serial port and
//! GPIO pins.
//!
//! In [`Pace::Stepped`] one [`Apparatus::step`] lets one period pass, synchronously and in this
//! order: the person acts on the percept last shown, the output callback is asked for the drive,
//! the plant answers, the input callback is given the samples, force samples that are due are
//! readable on the serial port, the pins have their new levels. The same seed, scenario and calls
//! give the same bits. In [`Pace::RealTime`] a thread does the same, level with the machine's clock.

mod faults;
mod masses;
mod outboard;
mod patchbay;
mod senses;
mod world;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::clock::{Lateness, Pace, WorldClock};
use crate::host::Audio;
use crate::pins::{PinBoard, Pins};
use crate::scenario::Scenario;
use crate::serial::DeviceStart;
use crate::vibrometer::Vibrometer;
pub use faults::FaultPanel;
pub use masses::Masses;
pub use outboard::{Outboard, Visit};
pub use patchbay::Patchbay;
pub use senses::Senses;
use world::{ForceSide, World};

/// Longest nap of the real-time thread: it then makes up for several periods at once.
const NAP: Duration = Duration::from_millis(1);

/// World periods that fit whole frames at every rate offered.
const PERIOD_FRAMES: std::ops::RangeInclusive<u32> = 16..=1920;
const PERIOD_MULTIPLE: u32 = 4;

/// What apparatus to simulate, and how.
#[derive(Debug, Clone)]
pub struct ApparatusConfig {
    /// What is true of bench and participant.
    pub scenario: Scenario,
    /// Seed of everything random about the bench, its noise included.
    pub seed: u64,
    /// Seed of the person, skin and habits; `seed` when absent.
    pub participant_seed: Option<u64>,
    /// Who advances the world.
    pub pace: Pace,
    /// Length of a world period, frames at 192 kHz: a multiple of 4 from 16 to 1920.
    pub period_frames: u32,
    /// Where the force sensor's counters begin; drawn by `seed` when absent.
    pub force_start: Option<DeviceStart>,
    /// An existing folder to write `truth.json` and `truth.csv` into, from the first period on in
    /// which a stream of the bench's converter is open; nowhere when absent.
    pub truth_path: Option<PathBuf>,
}

impl ApparatusConfig {
    /// An apparatus with default period and no truth file.
    #[must_use]
    pub fn new(scenario: Scenario, seed: u64, pace: Pace) -> Self {
        Self {
            scenario,
            seed,
            participant_seed: None,
            pace,
            period_frames: 64,
            force_start: None,
            truth_path: None,
        }
    }
}

/// Why the apparatus cannot be built or go on.
#[derive(Debug, thiserror::Error)]
pub enum ApparatusError {
    /// A world period that the sound cards' rates do not divide.
    #[error("a period of {frames} frames is not a multiple of 4 within 16 to 1920")]
    Period {
        /// The period asked for, frames at 192 kHz.
        frames: u32,
    },
    /// A serial line could not be made or has failed.
    #[error("serial line: {0}")]
    Serial(#[source] io::Error),
    /// The truth could not be written.
    #[error("truth of the run: {0}")]
    Truth(#[source] io::Error),
    /// There is no folder for the truth.
    #[error("no folder {} for the truth of the run: make it first", path.display())]
    NoTruthFolder {
        /// Where it should be.
        path: PathBuf,
    },
    /// The real-time thread could not be started.
    #[error("the apparatus' thread: {0}")]
    Thread(#[source] io::Error),
    /// [`Apparatus::step`] on a world that advances by itself.
    #[error("a real-time apparatus advances by itself")]
    NotStepped,
    /// The real-time thread has panicked, in one of the bench's callbacks or in the simulation.
    #[error("the apparatus' thread has panicked")]
    Panicked,
}

enum Driver {
    Stepped(Box<World>),
    RealTime(Option<JoinHandle<Result<(), ApparatusError>>>),
}

/// A simulated apparatus; it exists until dropped.
pub struct Apparatus {
    clock: Arc<WorldClock>,
    audio: Arc<Audio>,
    board: Arc<PinBoard>,
    force: ForceSide,
    senses: Senses,
    patchbay: Patchbay,
    masses: Masses,
    pins: Option<Pins>,
    force_port: PathBuf,
    vibrometer_port: PathBuf,
    stop: Arc<AtomicBool>,
    driver: Driver,
}

impl Apparatus {
    /// Builds the apparatus; in real time it starts at once.
    ///
    /// # Errors
    /// [`ApparatusError`], when the period fits no sound card, the system gives no pseudo-terminal
    /// or the truth file cannot be created.
    pub fn new(config: ApparatusConfig) -> Result<Self, ApparatusError> {
        let frames = config.period_frames;
        if !PERIOD_FRAMES.contains(&frames) || !frames.is_multiple_of(PERIOD_MULTIPLE) {
            return Err(ApparatusError::Period { frames });
        }
        if let Some(path) = config.truth_path.as_ref().filter(|path| !path.is_dir()) {
            return Err(ApparatusError::NoTruthFolder { path: path.clone() });
        }
        let scenario = &config.scenario;
        let clock = Arc::new(WorldClock::new(
            config.pace,
            frames,
            scenario.converter.clock_ppm,
        ));
        let audio = Audio::new(Arc::clone(&clock), &scenario.converter);
        let board = PinBoard::new(scenario, Arc::clone(&clock));
        let senses = Senses::default();
        let force = ForceSide::open(
            &scenario.force_sensor,
            config
                .force_start
                .unwrap_or_else(|| DeviceStart::draw(config.seed)),
            config.pace == Pace::Stepped,
        )?;
        let force_port = force.path();
        let vibrometer = Vibrometer::open(config.seed, config.pace == Pace::Stepped)
            .map_err(ApparatusError::Serial)?;
        let vibrometer_port = vibrometer.path().to_owned();
        let world = Box::new(World::new(
            &config, &clock, &audio, &board, &force, &senses, vibrometer,
        ));
        let patchbay = world.patchbay();
        let masses = world.masses();
        let stop = Arc::new(AtomicBool::new(false));
        let driver = match config.pace {
            Pace::Stepped => Driver::Stepped(world),
            Pace::RealTime => Driver::RealTime(Some(keep_pace(world, &clock, &stop)?)),
        };
        Ok(Self {
            pins: Some(board.pins()),
            clock,
            audio,
            board,
            force,
            senses,
            patchbay,
            masses,
            force_port,
            vibrometer_port,
            stop,
            driver,
        })
    }

    /// The sound cards.
    #[must_use]
    pub fn host(&self) -> cpal::Host {
        self.audio.host()
    }

    /// The force sensor's serial port, to be opened by path.
    ///
    /// In a stepped world only the thread that steps may read it: a step waits until its burst is
    /// readable, and fails after a second when somebody has taken it meanwhile.
    #[must_use]
    pub fn force_port(&self) -> &Path {
        &self.force_port
    }

    /// The serial port of a vibrometer on the plate, to be opened by path: a hundred lines a second, each the peak
    /// amplitude in µm. In a stepped world only the thread that steps may read it.
    #[must_use]
    pub fn vibrometer_port(&self) -> &Path {
        &self.vibrometer_port
    }

    /// The digital lines; `None` after they were taken once.
    pub fn pins(&mut self) -> Option<Pins> {
        self.pins.take()
    }

    /// The participant's eyes and ears.
    #[must_use]
    pub fn senses(&self) -> Senses {
        self.senses.clone()
    }

    /// The inputs' cables.
    #[must_use]
    pub fn patchbay(&self) -> Patchbay {
        self.patchbay.clone()
    }

    /// Known masses for the force sensor.
    #[must_use]
    pub fn masses(&self) -> Masses {
        self.masses.clone()
    }

    /// What can be made to go wrong.
    #[must_use]
    pub fn faults(&self) -> FaultPanel {
        FaultPanel::new(&self.audio, &self.board, &self.force)
    }

    /// World time; to be asked by any thread.
    #[must_use]
    pub fn clock(&self) -> ApparatusClock {
        ApparatusClock(Arc::clone(&self.clock))
    }

    /// World time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    /// How well real time was kept.
    #[must_use]
    pub fn lateness(&self) -> Lateness {
        self.clock.lateness()
    }

    /// Frames that the speakers have played.
    #[must_use]
    pub fn speaker_frames(&self) -> u64 {
        self.audio.speaker_frames()
    }

    /// Bytes of the force sensor lost because nobody took them in time.
    #[must_use]
    pub fn force_bytes_dropped(&self) -> u64 {
        self.force.dropped_bytes()
    }

    /// Lets one period of a stepped world pass.
    ///
    /// # Errors
    /// [`ApparatusError::NotStepped`] in real time; otherwise what the serial line or the truth
    /// file ran into.
    pub fn step(&mut self) -> Result<(), ApparatusError> {
        match &mut self.driver {
            Driver::Stepped(world) => world.step(),
            Driver::RealTime(_) => Err(ApparatusError::NotStepped),
        }
    }

    /// Ends the world and the truth of the run.
    ///
    /// # Errors
    /// What ended a real-time world early, or that the truth could not be written.
    pub fn finish(mut self) -> Result<(), ApparatusError> {
        self.end()
    }

    fn end(&mut self) -> Result<(), ApparatusError> {
        self.stop.store(true, Ordering::Release);
        match &mut self.driver {
            Driver::Stepped(world) => world.finish(),
            Driver::RealTime(thread) => match thread.take() {
                Some(thread) => thread.join().unwrap_or(Err(ApparatusError::Panicked)),
                None => Ok(()),
            },
        }
    }
}

impl Drop for Apparatus {
    fn drop(&mut self) {
        // Who wants to know calls `finish`.
        let _ = self.end();
    }
}

/// World time, for threads that do not hold the apparatus.
#[derive(Debug, Clone)]
pub struct ApparatusClock(Arc<WorldClock>);

impl ApparatusClock {
    /// World time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.0.now_ns()
    }
}

fn keep_pace(
    mut world: Box<World>,
    clock: &Arc<WorldClock>,
    stop: &Arc<AtomicBool>,
) -> Result<JoinHandle<Result<(), ApparatusError>>, ApparatusError> {
    let (clock, stop) = (Arc::clone(clock), Arc::clone(stop));
    std::thread::Builder::new()
        .name("apparatus".into())
        .spawn(move || {
            while !stop.load(Ordering::Acquire) {
                if clock.until_due().is_zero() {
                    world.step()?;
                } else {
                    std::thread::sleep(clock.until_due().max(NAP));
                }
            }
            world.finish()
        })
        .map_err(ApparatusError::Thread)
}
