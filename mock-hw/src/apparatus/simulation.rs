//! The assembled apparatus, and the thread or caller that advances it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use super::apparatus_error::ApparatusError;
use super::dead_man_hand::DeadManHand;
use super::fault_panel::FaultPanel;
use super::force_side::ForceSide;
use super::mass_set::MassSet;
use super::patchbay::Patchbay;
use super::rehearsal_hand::RehearsalHand;
use super::senses::Senses;
use super::settings::ApparatusConfig;
use super::world::World;
use crate::host::{SoundCards, cpal_host};
use crate::oscilloscope::Oscilloscope;
use crate::pins::{PinBoard, Pins};
use crate::rack::Rack;
use crate::serial::DeviceStart;
use crate::vibrometer::{Vibrometer, VibrometerAim};
use crate::voltmeter::Voltmeter;
use crate::world_clock::{Lateness, WorldClock, WorldPace};

/// Longest sleep of the real-time thread; it then catches up over several periods at once.
const LONGEST_SLEEP: Duration = Duration::from_millis(1);

/// Periods, in frames at 192 kHz, with whole frames at every rate of the sound cards.
const PERIOD_FRAMES: std::ops::RangeInclusive<u32> = 16..=1920;
const PERIOD_MULTIPLE: u32 = 4;

/// Driver of the simulated time.
enum Driver {
    Stepped(Box<World>),
    RealTime(Option<JoinHandle<Result<(), ApparatusError>>>),
}

/// Simulated apparatus; exists until dropped.
///
/// ```
/// use cpal::traits::{DeviceTrait, HostTrait};
/// use mock_hw::apparatus::{Apparatus, ApparatusConfig, ApparatusError};
/// use mock_world::scenario::built_in;
/// use mock_hw::world_clock::WorldPace;
///
/// let scenario = built_in("nominal").expect("a built-in scenario");
/// let mut apparatus = Apparatus::new(ApparatusConfig::new(scenario, 1, WorldPace::Stepped))?;
/// let cards: Vec<_> = apparatus.host().devices().expect("devices").collect();
/// assert_eq!(cards.len(), 2);
/// assert!(cards[0].default_input_config().is_ok());
///
/// // Three thousand periods of 64 frames at 192 kHz make a second.
/// for _ in 0..3_000 {
///     apparatus.step()?;
/// }
/// assert_eq!(apparatus.now_ns(), 1_000_000_000);
/// apparatus.finish()?;
/// # Ok::<(), ApparatusError>(())
/// ```
pub struct Apparatus {
    clock: Arc<WorldClock>,
    cards: Arc<SoundCards>,
    board: Arc<PinBoard>,
    force: ForceSide,
    senses: Senses,
    patchbay: Patchbay,
    masses: MassSet,
    rehearsal: RehearsalHand,
    pins: Option<Pins>,
    force_port: Option<PathBuf>,
    box_port: Option<PathBuf>,
    vibrometer_port: Option<PathBuf>,
    vibrometer_aim: VibrometerAim,
    voltmeter_port: Option<PathBuf>,
    stop: Arc<AtomicBool>,
    driver: Driver,
}

impl Apparatus {
    /// Builds the apparatus; in real time it starts immediately.
    ///
    /// # Errors
    /// [`ApparatusError`] if the period fits no sound card, the folder for the truth does not exist, or the operating system
    /// refuses a pseudo-terminal, the oscilloscope's file or the real-time thread.
    pub fn new(config: ApparatusConfig) -> Result<Self, ApparatusError> {
        let frames = config.period_frames;
        if !PERIOD_FRAMES.contains(&frames) || !frames.is_multiple_of(PERIOD_MULTIPLE) {
            return Err(ApparatusError::Period {
                frames,
                multiple: PERIOD_MULTIPLE,
                low: *PERIOD_FRAMES.start(),
                high: *PERIOD_FRAMES.end(),
            });
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
        let cards = SoundCards::new(
            Arc::clone(&clock),
            &scenario.converter,
            config.acquisition_card,
        );
        let board = PinBoard::new(scenario, Arc::clone(&clock));
        let senses = Senses::default();
        let force = ForceSide::open(
            &scenario.force_sensor,
            config
                .force_start
                .unwrap_or_else(|| DeviceStart::draw(config.seed)),
            config.pace == WorldPace::Stepped,
            Some(&board),
        )?;
        let (force_port, box_port) = (force.path(), force.box_path());
        let vibrometer = Vibrometer::open(config.seed, config.pace == WorldPace::Stepped)
            .map_err(ApparatusError::Serial)?;
        let (vibrometer_port, vibrometer_aim) =
            (vibrometer.path().map(Path::to_owned), vibrometer.aim());
        let is_stepped = config.pace == WorldPace::Stepped;
        let voltmeter = Voltmeter::open(&scenario.meter, config.seed, is_stepped)
            .map_err(ApparatusError::Serial)?;
        let voltmeter_port = voltmeter.path().map(Path::to_owned);
        let oscilloscope = oscilloscope(config.oscilloscope_path.as_deref())?;
        let world = Box::new(World::new(
            &config,
            &clock,
            &cards,
            &board,
            &force,
            &senses,
            (vibrometer, voltmeter, oscilloscope),
        ));
        let patchbay = world.patchbay();
        let masses = world.masses();
        let rehearsal = world.rehearsal();
        let stop = Arc::new(AtomicBool::new(false));
        let driver = match config.pace {
            WorldPace::Stepped => Driver::Stepped(world),
            WorldPace::RealTime => Driver::RealTime(Some(keep_pace(world, &clock, &stop)?)),
        };
        Ok(Self {
            pins: Some(board.pins()),
            clock,
            cards,
            board,
            force,
            senses,
            patchbay,
            masses,
            rehearsal,
            force_port,
            box_port,
            vibrometer_port,
            vibrometer_aim,
            voltmeter_port,
            stop,
            driver,
        })
    }

    /// Returns the cpal host with the simulated sound cards.
    #[must_use]
    pub fn host(&self) -> cpal::Host {
        cpal_host(&self.cards)
    }

    /// Returns the path of the force sensor's serial port.
    ///
    /// In a stepped apparatus only the stepping thread may read it: a step waits until its burst is readable, and times out if
    /// another thread has read it.
    ///
    /// # Errors
    /// [`ApparatusError::NoSerialPort`] if the sensor is on the network, or the operating system has no pseudo-terminals.
    pub fn force_port(&self) -> Result<&Path, ApparatusError> {
        port(&self.force_port, "force sensor")
    }

    /// Returns the path of the field box's serial port; `None` if there is no box.
    #[must_use]
    pub fn box_port(&self) -> Option<&Path> {
        self.box_port.as_deref()
    }

    /// Returns the network address of the force sensor; `None` if it is on a serial line.
    #[must_use]
    pub fn force_address(&self) -> Option<SocketAddr> {
        self.force.address()
    }

    /// Returns whether the force sensor is on inputs of the sound card, without a port or address.
    #[must_use]
    pub fn force_is_on_card(&self) -> bool {
        self.force.is_on_card()
    }

    /// Returns the path of the serial port of a vibrometer on the plate.
    ///
    /// The vibrometer sends 100 lines per second, each the peak amplitude in µm. In a stepped apparatus only the stepping
    /// thread may read them.
    ///
    /// # Errors
    /// [`ApparatusError::NoSerialPort`] if the operating system has no pseudo-terminals.
    pub fn vibrometer_port(&self) -> Result<&Path, ApparatusError> {
        port(&self.vibrometer_port, "vibrometer")
    }

    /// Returns a handle that aims the vibrometer.
    #[must_use]
    pub fn vibrometer_aim(&self) -> VibrometerAim {
        self.vibrometer_aim.clone()
    }

    /// Returns the path of the serial port of a voltmeter across the actuators: 20 lines per second, each the true RMS in V. In
    /// a stepped apparatus only the stepping thread may read them.
    ///
    /// # Errors
    /// [`ApparatusError::NoSerialPort`] if the operating system has no pseudo-terminals.
    pub fn voltmeter_port(&self) -> Result<&Path, ApparatusError> {
        port(&self.voltmeter_port, "voltmeter")
    }

    /// Takes the digital lines; `None` after the first call.
    pub fn pins(&mut self) -> Option<Pins> {
        self.pins.take()
    }

    /// Returns the apparatus for a simulated library of National Instruments.
    #[must_use]
    pub fn rack(&self) -> Rack {
        Rack::new(&self.cards, &self.board)
    }

    /// Returns a handle that shows percepts to the simulated person.
    #[must_use]
    pub fn senses(&self) -> Senses {
        self.senses.clone()
    }

    /// Returns the hand at the dead-man switch.
    #[must_use]
    pub fn dead_man_hand(&self) -> DeadManHand {
        DeadManHand::new(&self.board)
    }

    /// Returns a handle that connects the cables of the inputs.
    #[must_use]
    pub fn patchbay(&self) -> Patchbay {
        self.patchbay.clone()
    }

    /// Returns a handle that places known masses on the force sensor.
    #[must_use]
    pub fn masses(&self) -> MassSet {
        self.masses.clone()
    }

    /// Returns a handle that injects faults.
    #[must_use]
    pub fn faults(&self) -> FaultPanel {
        FaultPanel::new(&self.cards, &self.board, &self.force)
    }

    /// Returns a handle that injects faults by name.
    #[must_use]
    pub fn rehearsal(&self) -> RehearsalHand {
        self.rehearsal.clone()
    }

    /// Returns a clock of the simulated time for other threads.
    #[must_use]
    pub fn clock(&self) -> ApparatusClock {
        ApparatusClock(Arc::clone(&self.clock))
    }

    /// Returns the simulated time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    /// Returns the delays of the simulation against real time.
    #[must_use]
    pub fn lateness(&self) -> Lateness {
        self.clock.lateness()
    }

    /// Returns the number of frames played by the speakers.
    #[must_use]
    pub fn speaker_frames(&self) -> u64 {
        self.cards.speaker_frames()
    }

    /// Advances a stepped apparatus by one period.
    ///
    /// # Errors
    /// [`ApparatusError::NotStepped`] in real time; [`ApparatusError::Serial`] or [`ApparatusError::Truth`] if a serial line or
    /// a truth file fails.
    pub fn step(&mut self) -> Result<(), ApparatusError> {
        match &mut self.driver {
            Driver::Stepped(world) => world.step(),
            Driver::RealTime(_) => Err(ApparatusError::NotStepped),
        }
    }

    /// Ends the simulation and completes the truth files.
    ///
    /// # Errors
    /// The error that ended a real-time simulation early, or [`ApparatusError::Truth`].
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
        // A caller interested in the error calls `finish`.
        let _ = self.end();
    }
}

/// Clock of the simulated time, for threads without access to the apparatus.
#[derive(Debug, Clone)]
pub struct ApparatusClock(Arc<WorldClock>);

impl ApparatusClock {
    /// Returns the simulated time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.0.now_ns()
    }
}

fn port<'a>(path: &'a Option<PathBuf>, device: &'static str) -> Result<&'a Path, ApparatusError> {
    path.as_deref()
        .ok_or(ApparatusError::NoSerialPort { device })
}

fn oscilloscope(path: Option<&Path>) -> Result<Option<Oscilloscope>, ApparatusError> {
    let open = |path: &Path| {
        Oscilloscope::open(path).map_err(|source| ApparatusError::Oscilloscope {
            path: path.to_owned(),
            source,
        })
    };
    path.map(open).transpose()
}

/// Starts the thread that keeps the simulation in step with the machine's clock.
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
                    std::thread::sleep(clock.until_due().max(LONGEST_SLEEP));
                }
            }
            world.finish()
        })
        .map_err(ApparatusError::Thread)
}
