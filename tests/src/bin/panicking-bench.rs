//! The bench on simulated hardware in real time, one part of which panics while the plate is driven:
//! `panicking-bench PART FOLDER run --mock …`, with the options of `friction-bench`.
//!
//! A part is a task, named by its thread. The bench's clock, which every task reads before each poll, panics on that thread, so
//! the program needs no code for this test. `OTHER_THREAD` is no task: it panics on a thread with that name. The history of the
//! lines is written to `FOLDER/report.json`.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use bench_tests::panicking::{Edge, HAND, OTHER_THREAD, Report};
use clap::Parser;
use config::{Config, Effective};
use devices::Hardware;
use friction_bench::apparatus::BenchHardware;
use friction_bench::cli::{Calibrate, Cli, Command};
use friction_bench::drilling::WatchedHardware;
use friction_bench::run::SessionPlan;
use friction_bench::verbosity::Verbosity;
use friction_bench::{calibrate, drilling, ending, monitor, run};
use jiff::Timestamp;
use mock_hw::apparatus::{Apparatus as Simulated, ApparatusClock, ApparatusConfig};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use preflight::Extent;
use safety::{GpioError, OutputLine, input, output};
use sources::Lines;
use tasks::{Clock, Schedule, SystemClock};

/// Time from arming to the panic, on the apparatus's clock: the drive has ramped up, and audio is being recorded.
const DRIVEN_NS: u64 = 800_000_000;

/// Observations of the bench from outside.
struct Observations {
    part: String,
    time: ApparatusClock,
    /// Whether the part panics at its next reading of the clock.
    panics: AtomicBool,
    panicked_ns: AtomicU64,
    edges: Mutex<Vec<Edge>>,
    readers: Mutex<BTreeSet<String>>,
}

impl Observations {
    fn panic(&self) -> ! {
        self.panicked_ns
            .store(self.time.now_ns(), Ordering::Release);
        panic!("on purpose");
    }

    fn report(&self) -> Report {
        let readers = self.readers.lock().unwrap_or_else(PoisonError::into_inner);
        let edges = self.edges.lock().unwrap_or_else(PoisonError::into_inner);
        Report {
            panicked_ns: self.panicked_ns.load(Ordering::Acquire),
            edges: edges.clone(),
            clock_readers: readers.clone(),
        }
    }
}

/// The computer's clock, which panics once when the chosen thread reads it.
struct PanickingClock {
    clock: SystemClock,
    observations: Arc<Observations>,
}

impl Clock for PanickingClock {
    fn now_ns(&self) -> u64 {
        let thread = std::thread::current();
        let name = thread.name().unwrap_or_default();
        let observations = &self.observations;
        let add_reader = |readers: &mut BTreeSet<String>| {
            if !readers.contains(name) {
                readers.insert(name.to_owned());
            }
        };
        add_reader(
            &mut observations
                .readers
                .lock()
                .unwrap_or_else(PoisonError::into_inner),
        );
        if name == observations.part && observations.panics.swap(false, Ordering::AcqRel) {
            observations.panic();
        }
        self.clock.now_ns()
    }

    fn utc(&self) -> Timestamp {
        self.clock.utc()
    }
}

/// Output line that records its edges.
struct RecordedLine {
    name: &'static str,
    line: Box<dyn OutputLine>,
    high: bool,
    observations: Arc<Observations>,
}

impl OutputLine for RecordedLine {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        self.line.set(high)?;
        if high != self.high {
            self.high = high;
            let edge = Edge {
                at_ns: self.observations.time.now_ns(),
                line: self.name.to_owned(),
                high,
            };
            let mut edges = self
                .observations
                .edges
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            edges.push(edge);
        }
        Ok(())
    }
}

/// Waits until the plate has been driven for a while, then makes the part panic.
fn panic_while_driven(observations: &Observations) {
    let armed_ns = || {
        let edges = observations
            .edges
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let mut edges = edges.iter();
        edges
            .find(|edge| edge.line == "enable")
            .map(|edge| edge.at_ns)
    };
    while armed_ns().is_none_or(|armed_ns| observations.time.now_ns() < armed_ns + DRIVEN_NS) {
        std::thread::sleep(Duration::from_millis(5));
    }
    if observations.part == OTHER_THREAD {
        observations.panic();
    }
    observations.panics.store(true, Ordering::Release);
}

fn apparatus(part: &str, folder: &Path) -> anyhow::Result<(BenchHardware, Arc<Observations>)> {
    let mut config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::RealTime);
    config.truth_path = Some(folder.to_owned());
    let mut simulated = Simulated::new(config)?;
    let observations = Arc::new(Observations {
        part: part.to_owned(),
        time: simulated.clock(),
        panics: AtomicBool::new(false),
        panicked_ns: AtomicU64::new(0),
        edges: Mutex::default(),
        readers: Mutex::default(),
    });
    let recorded_line = |name, line| -> Option<Box<dyn OutputLine>> {
        Some(Box::new(RecordedLine {
            name,
            line,
            high: false,
            observations: Arc::clone(&observations),
        }))
    };
    let pins = simulated.pins().context("no pins")?;
    let lines = Lines {
        counter: None,
        encoder: Some([
            input("encoder A", pins.encoder_a),
            input("encoder B", pins.encoder_b),
        ]),
        estop: Some(input("e-stop", pins.estop)),
        button: Some(input("button", pins.button)),
        dead_man: None,
        enable: recorded_line("enable", output("enable", pins.amplifier_enable)),
        heartbeat: recorded_line("heartbeat", output("heartbeat", pins.heartbeat)),
    };
    let hand = {
        let observations = Arc::clone(&observations);
        let name = if part == OTHER_THREAD {
            OTHER_THREAD
        } else {
            HAND
        };
        std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || panic_while_driven(&observations))?
    };
    drop(hand);
    let hardware = Hardware {
        cues: None,
        host: simulated.host(),
        lines,
        force_place: Some(sources::Place::Port(simulated.force_port()?.to_owned())),
        field_box: None,
        clock: Arc::new(PanickingClock {
            clock: SystemClock::start(),
            observations: Arc::clone(&observations),
        }),
        schedule: Schedule::Threads,
        guard: Box::new(simulated),
        simulated: true,
        pace: safety::Pace::Simulated,
        // Each bench has its own folder.
        keeps_accounts: true,
    };
    let apparatus = BenchHardware {
        hardware,
        watchers: Vec::new(),
        displays: participant_displays::Displays::default(),
        rehearsed: Vec::new(),
        hands: None,
        fault_hand: None,
        voltmeter_port: None,
        vibrometer_port: None,
        estop_hand: None,
    };
    Ok((apparatus, observations))
}

fn read_config(path: &Option<PathBuf>) -> anyhow::Result<Config> {
    Ok(Config::read(path.as_deref().context("--config")?)?)
}

/// Runs the command on that apparatus; returns whether it completed.
fn command(command: Command, apparatus: BenchHardware) -> anyhow::Result<bool> {
    match command {
        Command::Run(options) => {
            let bench = Effective::uncalibrated(read_config(&options.hardware.config)?);
            let (report, _) = run::run(
                SessionPlan::new(bench, &options)?,
                apparatus,
                run::terminal_front(std::io::stdout()),
            )?;
            Ok(report.completed)
        }
        Command::Monitor(options) => {
            let bench = Effective::uncalibrated(read_config(&options.hardware.config)?);
            let plan = monitor::MonitorPlan::new(bench, &options)?;
            monitor::run(plan, apparatus, std::io::stdout())
        }
        Command::Calibrate(Calibrate::Plate(options)) => {
            let config = read_config(&options.measure.hardware.config)?;
            Ok(calibrate::plate(config, &options, Verbosity::Quiet, |_| Ok(apparatus))?.passed)
        }
        Command::Check(options) => {
            let bench = Effective::uncalibrated(read_config(&options.hardware.config)?);
            let pace = safety::Pace::Simulated;
            let extent = Extent::Quick;
            let ready = preflight::run(&bench, None, &extent, pace, || Ok(apparatus.hardware))?;
            std::io::stdout().write_all(ready.table.to_text().as_bytes())?;
            Ok(ready.table.passed())
        }
        Command::Drill(options) => {
            let config = read_config(&options.hardware.config)?;
            let course = drilling::plan(Effective::uncalibrated(config.clone()), &options)?;
            let mut bench = Some(WatchedHardware {
                hardware: apparatus.hardware,
                hand: None,
            });
            let open = || bench.take().context("opened twice");
            let (record, _) = drilling::run(&course, &options, &config, open, std::io::stdout())?;
            Ok(record.passed)
        }
        command => anyhow::bail!("{command:?} drives nothing"),
    }
}

fn main() -> ExitCode {
    ending::run(|| {
        let mut arguments = std::env::args().skip(1);
        let part = arguments.next().context("PART")?;
        let folder = PathBuf::from(arguments.next().context("FOLDER")?);
        let program = std::iter::once("friction-bench".to_owned());
        let cli = Cli::parse_from(program.chain(arguments));
        let (apparatus, observations) = apparatus(&part, &folder)?;
        let completion = command(cli.command, apparatus);
        std::fs::write(
            folder.join("report.json"),
            serde_json::to_vec(&observations.report())?,
        )?;
        Ok(if completion? {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    })
}
