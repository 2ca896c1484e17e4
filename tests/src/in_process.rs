//! Sessions and calibrations in this process, on a simulated apparatus in place of hardware.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::sync::Arc;

use config::Config;
use devices::Hardware;
use friction_bench::apparatus::{BenchHardware as Bench, Watcher};
use friction_bench::cli;
use jiff::{SignedDuration, Timestamp};
use mock_hw::apparatus::{Apparatus, ApparatusClock, ApparatusConfig, FaultPanel};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use safety::{InputLine, input, output};
use sources::Lines;
use tasks::{Clock, Schedule, later};

use crate::program::protocol;
use crate::simulated_person;

/// Clock of the apparatus, with a date that is set back and forth by hours.
struct SetClock {
    clock: ApparatusClock,
    /// Start of each wrong date, s, and its error, h.
    date_errors: &'static [(f64, i64)],
}

impl Clock for SetClock {
    fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    fn utc(&self) -> Timestamp {
        let date: Timestamp = "2026-01-01T09:00:00Z".parse().unwrap();
        let now_s = self.now_ns() as f64 * 1e-9;
        let error = self
            .date_errors
            .iter()
            .rev()
            .find(|(from_s, _)| now_s >= *from_s);
        let offset = SignedDuration::from_hours(error.map_or(0, |(_, hours)| *hours));
        later(date, self.now_ns()).checked_add(offset).unwrap()
    }
}

/// Parts of a session's bench.
#[derive(Default)]
pub struct Setup {
    /// The simulated scenario.
    pub scenario: Scenario,
    /// Whether the participant has a button.
    pub button: bool,
    /// Start of each wrong date, s, and its error, h.
    pub date_errors: &'static [(f64, i64)],
    /// Whether it passes for hardware.
    pub is_real: bool,
    /// The dead-man switch, and the person who holds it.
    pub dead_man: Option<(Box<dyn InputLine>, Watcher)>,
}

/// Returns a bench in lock step.
pub fn apparatus(setup: Setup) -> Bench {
    apparatus_with_faults(setup).0
}

/// Returns a bench in lock step, and a panel to inject its faults.
pub fn apparatus_with_faults(setup: Setup) -> (Bench, FaultPanel) {
    let Setup {
        scenario,
        button,
        date_errors,
        is_real,
        dead_man,
    } = setup;
    let (dead_man, holder) = dead_man.unzip();
    let config = ApparatusConfig::new(scenario, 1, WorldPace::Stepped);
    let mut apparatus = Apparatus::new(config).unwrap();
    let pins = apparatus.pins().unwrap();
    let clock = SetClock {
        clock: apparatus.clock(),
        date_errors,
    };
    let mut watchers = vec![simulated_person::participant(apparatus.senses())];
    watchers.extend(holder);
    let hands = simulated_person::hands(
        apparatus.masses(),
        apparatus.patchbay(),
        apparatus.senses(),
        apparatus.vibrometer_aim(),
    );
    let vibrometer_port = apparatus.vibrometer_port().unwrap().to_owned();
    let faults = apparatus.faults();
    let hardware = Hardware {
        cues: None,
        host: apparatus.host(),
        lines: Lines {
            counter: None,
            encoder: Some([
                input("encoder A", pins.encoder_a),
                input("encoder B", pins.encoder_b),
            ]),
            estop: Some(input("e-stop", pins.estop)),
            button: button.then(|| input("button", pins.button)),
            dead_man,
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(output("heartbeat", pins.heartbeat)),
        },
        force_place: Some(sources::Place::Port(
            apparatus.force_port().unwrap().to_owned(),
        )),
        field_box: None,
        clock: Arc::new(clock),
        guard: Box::new(()),
        simulated: !is_real,
        pace: if is_real {
            safety::Pace::Card
        } else {
            safety::Pace::Simulated
        },
        keeps_accounts: is_real,
        schedule: Schedule::Lockstep(Box::new(move || Ok(apparatus.step()?))),
    };
    let bench = Bench {
        fault_hand: None,
        voltmeter_port: None,
        hardware,
        watchers,
        displays: participant_displays::Displays::default(),
        rehearsed: Vec::new(),
        hands: Some(hands),
        vibrometer_port: Some(vibrometer_port),
        estop_hand: None,
    };
    (bench, faults)
}

/// Returns the simulated bench's configuration with some lines changed.
pub fn config(changes: &[(&str, &str)]) -> Config {
    let text = config::rigs::MOCK_BENCH.to_owned();
    let text = changes.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "no `{from}`");
        text.replacen(from, to, 1)
    });
    Config::parse(&text, "bench.toml").unwrap()
}

/// Returns the options of a session of one exploration.
pub fn options(study: &Path) -> cli::Run {
    cli::Run {
        accept: Vec::new(),
        rehearsal: cli::Rehearsal::default(),
        hardware: cli::HardwareOptions {
            config: None,
            mock: Some("nominal".to_owned()),
            seed: None,
            print_config: false,
            calibration: None,
        },
        study: study.to_owned(),
        participant: Some("sub-01".to_owned()),
        protocol: protocol("one-exploration.toml").display().to_string(),
        consent_by: Some("A. Tester".to_owned()),
        age: None,
        sex: None,
        handedness: None,
        resume: false,
        new_session: false,
        pressure_hpa: None,
        accept_edited_protocol: false,
        repeat_lost: false,
        uncalibrated: true,
        headless: true,
        speed: cli::Speed::Max,
        mock_truth: None,
        shared: false,
        participant_display: None,
        participant_window: None,
    }
}
