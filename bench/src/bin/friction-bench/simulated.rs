//! Simulated apparatus in place of hardware.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::Context;
use config::{AudioHost, Config};
use devices::Hardware;
use drill::rehearsed;
use drill::{Deed, FaultHand};
use faults::RehearsedFault;
use friction_bench::apparatus::{BenchHardware, Watcher};
use friction_bench::cli::Speed;
use jiff::Timestamp;
use mock_hw::apparatus::{
    Apparatus as SimulatedApparatus, ApparatusClock, ApparatusConfig, DeadManHand, FaultPanel,
    RehearsalHand,
};
use mock_hw::rack;
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::{ForceInterface, ForceLineFormat, Scenario, ScenarioError, built_in};
use participant_displays::Displays;
use safety::{input, output};
use sources::{Lines, Place};
use tasks::{Clock, Schedule, SystemClock, later};

use super::simulated_person;

/// Configuration of a bench with the simulated hardware's usual force sensor. It states the assumptions of the bench; the
/// truth of a scenario differs from them where that of real hardware would.
const CONFIG: &str = config::rigs::MOCK_BENCH;
/// Lines of [`CONFIG`] for the force sensor's format, and their replacement for a sensor that sends lines of text.
const FRAMES: &str =
    "protocol = \"frames\"                # or lines, see docs/force-protocol.md\nbaud = 2000000\n";
const LINES: &str =
    "protocol = \"lines\"                 # or frames, see docs/force-protocol.md\nbaud = 115200\n";

/// Start and end of the force sensor's lines in [`CONFIG`], and the lines for other sensors.
const SERIAL: [&str; 2] = ["port = ", "\n\n[encoder]"];
const NETFT: &str = config::rigs::MOCK_BENCH_NETFT;
const GAUGES: &str = config::rigs::MOCK_BENCH_CHANNELS;
const FIELD_BOX: &str = config::rigs::MOCK_BENCH_FIELD_BOX;
/// Lines of [`CONFIG`] about the encoder and the digital lines, and their replacements behind a field box.
const BEHIND_BOX: [[&str; 2]; 2] = [
    ["[encoder]\n", "[encoder]\nsource = \"field-box\"\n"],
    ["backend = \"none\" ", "backend = \"field-box\" "],
];
const FOUR: &str = "input_channels = 4 ";
const NINE: &str = "input_channels = 9 ";

/// Returns the text of the configuration that fits the hardware of `scenario`.
pub fn config(scenario: &Scenario) -> String {
    let force = &scenario.force_sensor;
    match (force.interface, force.protocol) {
        (ForceInterface::Serial, ForceLineFormat::Frames) => CONFIG.to_owned(),
        (ForceInterface::Serial, ForceLineFormat::Lines) => substituted(CONFIG, FRAMES, LINES),
        (ForceInterface::Netft, _) => with_sensor(NETFT),
        (ForceInterface::FieldBox, _) => BEHIND_BOX
            .iter()
            .fold(with_sensor(FIELD_BOX), |text, [direct, boxed]| {
                substituted(&text, direct, boxed)
            }),
        (ForceInterface::Gauges, _) => substituted(&with_sensor(GAUGES), FOUR, NINE),
    }
}

/// Returns `text` with `line` in place of its only `old_line`.
///
/// # Panics
/// When the file of a simulated rig has no such line, or several.
fn substituted(text: &str, old_line: &str, line: &str) -> String {
    let count = text.matches(old_line).count();
    assert_eq!(
        count, 1,
        "the file of the simulated rig has {count} times {old_line:?}"
    );
    text.replace(old_line, line)
}

/// Returns [`CONFIG`] with another force sensor.
fn with_sensor(sensor: &str) -> String {
    let [from, to] = SERIAL.map(|line| CONFIG.find(line).unwrap_or(CONFIG.len()));
    format!("{}{}{}", &CONFIG[..from], sensor.trim_end(), &CONFIG[to..])
}

/// Configuration of a bench on the simulated National Instruments card.
const NI_CARD: &str = config::rigs::MOCK_BENCH_NIDAQMX;

/// Returns the cards of the simulated National Instruments library; empty if it was not built.
///
/// # Errors
/// When the apparatus behind the library cannot be built.
pub fn cards(scenario: &str) -> anyhow::Result<Vec<ni_daqmx::Card>> {
    let Some(library) = rack::library() else {
        return Ok(Vec::new());
    };
    let bench = Config::parse(NI_CARD, "the simulated card's configuration")?;
    let _apparatus = apparatus(scenario, 1, Speed::Max, None, &[], Some(&bench))?;
    ni_daqmx::cards(Some(&library))
}

/// Number of openings of simulated streams so far.
static OPENINGS: AtomicU64 = AtomicU64::new(0);

/// Environment variable with the file of an oscilloscope on the simulated drive, see `mock_hw::oscilloscope`.
const OSCILLOSCOPE: &str = "FRICTION_BENCH_OSCILLOSCOPE";

/// Date of a free-running apparatus, fixed so that the same seed gives the same files.
const FREE_RUNNING_DATE: &str = "2026-01-01T09:00:00Z";

/// Builds an apparatus with `faults` injected, in place of the hardware that `bench` names.
///
/// # Errors
/// When the scenario cannot be read or the apparatus cannot be built.
pub fn apparatus(
    scenario: &str,
    seed: u64,
    speed: Speed,
    truth: Option<&Path>,
    faults: &[RehearsedFault],
    bench: Option<&Config>,
) -> anyhow::Result<BenchHardware> {
    let card = bench.filter(|bench| bench.audio.host == AudioHost::Nidaqmx);
    let scenario = read(scenario)?.draw(seed);
    let pace = match speed {
        Speed::Real => WorldPace::RealTime,
        Speed::Max => WorldPace::Stepped,
    };
    let mut config = ApparatusConfig::new(scenario, seed, pace);
    config.opening = OPENINGS.fetch_add(1, Ordering::Relaxed);
    config.truth_path = truth.map(Path::to_owned);
    config.oscilloscope_path = std::env::var_os(OSCILLOSCOPE).map(PathBuf::from);
    config.faults = faults.to_vec();
    if card.is_some() {
        config = config.with_acquisition_card();
    }
    let mut apparatus = SimulatedApparatus::new(config).context("the simulated apparatus")?;
    let pins = apparatus
        .pins()
        .context("the simulated apparatus has no pins")?;
    let mut lines = Lines {
        counter: None,
        encoder: Some([
            input("encoder A", pins.encoder_a),
            input("encoder B", pins.encoder_b),
        ]),
        estop: Some(input("e-stop", pins.estop)),
        button: Some(input("button", pins.button)),
        dead_man: Some(input("dead-man switch", pins.dead_man)),
        enable: Some(output("amplifier enable", pins.amplifier_enable)),
        heartbeat: Some(output("heartbeat", pins.heartbeat)),
    };
    let voltmeter_port = apparatus.voltmeter_port()?.to_owned();
    let box_port = apparatus.box_port().map(Path::to_owned);
    let (mut host, mut cues) = (apparatus.host(), None);
    if let Some(bench) = card {
        let library = rack::library().context(
            "the simulated NI library is not next to this program: build it with `cargo build --release -p mock-nidaqmx`",
        )?;
        apparatus.rack().connect(&library)?;
        let card_lines = Lines {
            dead_man: lines.dead_man.take(),
            ..Lines::default()
        };
        cues = Some(host);
        (host, lines) = ni_daqmx::open(bench, Some(&library), card_lines)?;
    }
    let (force_place, vibrometer_port, clock) = (
        match apparatus.force_address() {
            Some(address) => Some(Place::Address(address)),
            None if apparatus.force_is_on_card() => None,
            None => Some(Place::Port(apparatus.force_port()?.to_owned())),
        },
        apparatus.vibrometer_port()?.to_owned(),
        apparatus.clock(),
    );
    let watchers = vec![
        simulated_person::participant(apparatus.senses()),
        holder(apparatus.dead_man_hand()),
    ];
    let hands = simulated_person::hands(
        apparatus.masses(),
        apparatus.patchbay(),
        apparatus.senses(),
        apparatus.vibrometer_aim(),
    );
    let estop_hand = estop_hand(apparatus.faults());
    let fault_hand = fault_hand(apparatus.rehearsal());
    let (clock, schedule, guard): (Arc<dyn Clock>, _, Box<dyn Send>) = match speed {
        Speed::Max => {
            let date = FREE_RUNNING_DATE
                .parse()
                .context("the date of free-running apparatus")?;
            (
                Arc::new(FreeClock { clock, date }),
                Schedule::Lockstep(Box::new(move || Ok(apparatus.step()?))),
                Box::new(()),
            )
        }
        // The apparatus advances on its own as long as it exists.
        Speed::Real => (
            Arc::new(SystemClock::start()),
            Schedule::Threads,
            Box::new(apparatus),
        ),
    };
    let hardware = Hardware {
        host,
        cues,
        lines,
        force_place,
        field_box: None,
        clock,
        schedule,
        guard,
        simulated: true,
        pace: safety::Pace::Simulated,
        keeps_accounts: false,
    };
    let hardware = match bench {
        Some(bench) => hardware.with_field_box(bench, box_port.as_deref())?,
        None => hardware,
    };
    Ok(BenchHardware {
        hardware,
        watchers,
        displays: Displays::default(),
        rehearsed: rehearsed::words(faults),
        hands: Some(hands),
        vibrometer_port: Some(vibrometer_port),
        voltmeter_port: Some(voltmeter_port),
        estop_hand: Some(estop_hand),
        fault_hand: Some(fault_hand),
    })
}

/// Returns the hand at the dead-man switch of a person who follows the participant's screen.
fn holder(hand: DeadManHand) -> Watcher {
    Box::new(move |view, _, _| {
        use protocols::Instruction::{
            Finished, HoldSwitch, Paused, ReleaseSwitch, Rest, SwitchReleased,
        };
        match view.instruction {
            HoldSwitch => hand.hold(),
            ReleaseSwitch | SwitchReleased | Rest | Paused | Finished => hand.let_go(),
            _ => {}
        }
    })
}

/// Returns the hand of a person who presses and releases the e-stop when asked.
fn estop_hand(faults: FaultPanel) -> Box<dyn FnOnce() + Send> {
    Box::new(move || {
        std::thread::spawn(move || {
            for pressed in [true, false] {
                std::thread::sleep(Duration::from_millis(500));
                faults.press_estop(pressed);
            }
        });
    })
}

/// Returns the hand that injects a drill's faults into the apparatus.
fn fault_hand(hand: RehearsalHand) -> FaultHand {
    Box::new(move |deed| match deed {
        Deed::Begin(fault) => hand.begin(fault, None),
        Deed::End(fault) => hand.end(fault),
    })
}

/// Reads a built-in scenario by its name, or any other by its path.
///
/// # Errors
/// An unknown name suggests the nearest one; an error in a file includes its line.
pub fn read(name: &str) -> anyhow::Result<Scenario> {
    let path = Path::new(name);
    let is_built_in = path.starts_with("laws") && !path.exists();
    let is_path = path.components().count() > 1 || path.extension().is_some() || path.exists();
    match built_in(name) {
        Err(ScenarioError::UnknownName { names, .. }) if is_path && !is_built_in => {
            let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
                .with_context(|| {
                    format!(
                        "cannot read the scenario {name}; built-in scenarios: {}",
                        names.join(", ")
                    )
                })?;
            Ok(Scenario::parse(&text, name)?)
        }
        scenario => Ok(scenario?),
    }
}

struct FreeClock {
    clock: ApparatusClock,
    date: Timestamp,
}

impl Clock for FreeClock {
    fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    fn utc(&self) -> Timestamp {
        later(self.date, self.clock.now_ns())
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mock_hw::pins::FIRST_HELD_NS;

    #[test]
    fn the_hand_at_the_switch_releases_and_presses_it_on_request() {
        let config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::Stepped);
        let mut apparatus = SimulatedApparatus::new(config).unwrap();
        let mut switch = input("dead-man switch", apparatus.pins().unwrap().dead_man);
        let mut hand = holder(apparatus.dead_man_hand());
        assert!(!switch.is_high().unwrap(), "open at first");
        let held_ns = apparatus.now_ns() + FIRST_HELD_NS;
        while apparatus.now_ns() < held_ns {
            assert!(!switch.is_high().unwrap());
            apparatus.step().unwrap();
        }
        assert!(switch.is_high().unwrap());
        for (instruction, is_held) in [
            (protocols::Instruction::ReleaseSwitch, false),
            (protocols::Instruction::HoldSwitch, true),
        ] {
            let view = tui::ScreenView {
                instruction,
                slider_m: None,
                plate_m: 0.1,
                start_m: 0.0,
                end_m: 0.1,
                countdown: None,
                mean_force_n: None,
                force_band_n: None,
                trial: 0,
                trials: 0,
                ..tui::ScreenView::default()
            };
            hand(&view, false, None);
            assert_eq!(switch.is_high().unwrap(), is_held, "{instruction:?}");
        }
    }

    #[test]
    fn a_scenario_is_read_by_its_name_or_by_its_path() {
        for name in ["nominal", "laws/adhesion"] {
            assert_eq!(read(name).unwrap(), built_in(name).unwrap());
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        std::fs::write(&path, "[participant]\nmu0 = 0.5\n").unwrap();
        assert_eq!(
            read(path.to_str().unwrap()).unwrap().participant.mu0,
            Some(0.5)
        );
    }

    #[test]
    fn each_scenario_brings_a_configuration_with_its_own_force_protocol() {
        for (name, protocol) in [
            ("nominal", config::ForceProtocol::Frames),
            ("arduino", config::ForceProtocol::Lines),
        ] {
            let text = config(&built_in(name).unwrap());
            let config = Config::parse(&text, name).unwrap();
            let config::Sensor::Serial(serial) = config.force.unwrap().sensor else {
                panic!("{name}: not on a serial line");
            };
            assert_eq!(serial.protocol, protocol, "{name}");
        }
    }

    #[test]
    fn a_sensor_without_a_serial_line_brings_its_own_configuration() {
        for (name, source) in [
            ("net-ft", "netft"),
            ("gauges", "channels"),
            ("field-box", "field-box"),
        ] {
            let scenario = built_in(name).unwrap();
            let config = Config::parse(&config(&scenario), name).unwrap();
            let inputs = usize::from(config.audio.input_channels);
            assert_eq!(inputs, scenario.converter.channels, "{name}");
            assert_eq!(config.force.unwrap().in_words(), source);
        }
    }

    #[test]
    fn an_unknown_name_suggests_the_nearest_scenario_and_an_absent_file_has_its_own_error() {
        let unknown = read("nominl").unwrap_err();
        assert!(matches!(
            unknown.downcast_ref(),
            Some(ScenarioError::UnknownName { nearest: Some(name), .. }) if name == "nominal"
        ));
        let unknown_law = read("laws/adhesoin").unwrap_err();
        assert!(matches!(
            unknown_law.downcast_ref(),
            Some(ScenarioError::UnknownName { nearest: Some(name), .. }) if name == "laws/adhesion"
        ));
        let absent = read("absent.toml").unwrap_err();
        let cause = absent.downcast_ref::<std::io::Error>().unwrap();
        assert_eq!(cause.kind(), std::io::ErrorKind::NotFound);
    }
}
