//! Facts on the bench for the operator.

use config::{CalibrationFile, Config, HardwareStop, Provenance, Quantity, unverified};
use devices::Hardware;
use jiff::Timestamp;
use safety::Pace;
use sources::Lines;
use tui::event::{BenchFacts, BenchLine, CalibrationFact, PartFact};

const DAY_S: f64 = 86_400.0;

/// Lines available on the bench, from any device.
#[derive(Debug, Clone, Copy)]
struct Wired {
    /// The e-stop's loop.
    estop: bool,
    /// The participant's button.
    button: bool,
    /// The amplifier's enable line.
    enable: bool,
    /// The heartbeat.
    heartbeat: bool,
}

impl Wired {
    /// Returns which lines are available.
    fn from_lines(lines: &Lines) -> Self {
        Self {
            estop: lines.estop.is_some(),
            button: lines.button.is_some(),
            enable: lines.enable.is_some(),
            heartbeat: lines.heartbeat.is_some(),
        }
    }
}

/// Returns calibrations, lines, sources and limits of the bench of `config`, with its calibrations in `file`. A date in
/// simulated time has no age in real time, and vice versa.
#[must_use]
pub fn facts(config: &Config, file: Option<&CalibrationFile>, hardware: &Hardware) -> BenchFacts {
    let clock = &hardware.clock;
    BenchFacts {
        plate: format!(
            "plate of {:.0} mm at {:.1} Hz",
            config.plate.length_m * 1e3,
            config.plate.resonance_hz
        ),
        calibrations: calibrations(file, clock.utc(), clock.is_simulated()),
        parts: parts(config, Wired::from_lines(&hardware.lines)),
        loosened: config.loosened(),
        unverified: match hardware.pace {
            Pace::Card => unverified(config, file, clock.utc()),
            Pace::Simulated => Vec::new(),
        },
    }
}

fn calibrations(
    file: Option<&CalibrationFile>,
    time: Timestamp,
    simulated: bool,
) -> Vec<CalibrationFact> {
    // The tare belongs to the calibration of the force sensor.
    let same_time = |name: &str| {
        let part = if name == "tare" { "force" } else { name };
        file.is_some_and(|file| file.is_in_simulated_time(part) == simulated)
    };
    let fact = |name: &str, measured: Option<(&Provenance, String)>| match measured {
        None => CalibrationFact {
            name: name.to_owned(),
            ..CalibrationFact::default()
        },
        Some((measured, value)) => {
            let age_s = time.duration_since(measured.date).as_secs_f64();
            CalibrationFact {
                name: name.to_owned(),
                date: Some(calendar::day(measured.date)),
                age_days: (same_time(name) && age_s >= 0.0).then_some(age_s / DAY_S),
                operator: measured.operator.clone(),
                value,
            }
        }
    };
    let value = |quantity: &Quantity| quantity.to_string();
    let pickup = file.and_then(|file| file.pickup.as_ref());
    let plate = file.and_then(|file| file.plate.as_ref());
    let force = file.and_then(|file| file.force.as_ref());
    let channels = file.and_then(|file| file.channels.as_ref());
    let output = file.and_then(|file| file.output.as_ref());
    vec![
        fact(
            "pickup",
            pickup.map(|pickup| (&pickup.measured, value(&pickup.metres_per_unit))),
        ),
        fact(
            "plate",
            plate.map(|plate| (&plate.measured, value(&plate.resonance_hz))),
        ),
        fact(
            "force",
            force.map(|force| (&force.measured, format!("{} masses", force.masses))),
        ),
        fact(
            "tare",
            force.map(|force| (&force.tared, value(&force.normal_tare))),
        ),
        fact(
            "channels",
            channels.map(|channels| (&channels.measured, value(&channels.latency))),
        ),
        fact(
            "output",
            output.map(|output| (&output.measured, output.meter.clone())),
        ),
    ]
}

fn parts(config: &Config, lines: Wired) -> Vec<PartFact> {
    let part = |name: &str, words: String, well: bool| PartFact {
        name: name.to_owned(),
        words,
        well,
        line: None,
    };
    let safety = &config.safety;
    let stop = |name: &str, line: HardwareStop, wired: bool| {
        let words = match (wired, safety.waiver_of(line)) {
            (_, Some(waiver)) => format!("waived by {waiver}"),
            (true, None) => "wired".to_owned(),
            (false, None) => "not wired".to_owned(),
        };
        let line = match line {
            HardwareStop::Estop => BenchLine::Estop,
            HardwareStop::Heartbeat => BenchLine::Heartbeat,
        };
        PartFact {
            line: Some(line),
            ..part(name, words, wired)
        }
    };
    let wired = |name: &str, wired: bool, absent_words: &str| {
        let words = if wired { "wired" } else { absent_words };
        part(name, words.to_owned(), wired)
    };
    let encoder = match &config.encoder {
        Some(encoder) => format!("{:?}", encoder.source).to_lowercase(),
        None => "none: no position, no stretch can be selected".to_owned(),
    };
    let force = config.force.as_ref();
    vec![
        stop("e-stop", HardwareStop::Estop, lines.estop),
        stop("heartbeat", HardwareStop::Heartbeat, lines.heartbeat),
        wired("enable", lines.enable, "not wired"),
        PartFact {
            line: Some(BenchLine::Button),
            ..wired(
                "button",
                lines.button,
                "none: a finger at rest counts as ready",
            )
        },
        part(
            "dead-man",
            if safety.dead_man.is_some() {
                "must be held"
            } else {
                "not used"
            }
            .to_owned(),
            true,
        ),
        PartFact {
            line: Some(BenchLine::Encoder),
            ..part("encoder", encoder, config.encoder.is_some())
        },
        PartFact {
            line: Some(BenchLine::ForceSensor),
            ..part(
                "force",
                force.map_or("none".to_owned(), |force| force.in_words()),
                force.is_some(),
            )
        },
        PartFact {
            line: Some(BenchLine::SoundCard),
            ..part(
                "sound card",
                format!(
                    "{} Hz, {} inputs, drive on {}, pickup on {}",
                    config.audio.rate_hz,
                    config.audio.input_channels,
                    config.channels.drive.index,
                    config.channels.pickup.index
                ),
                true,
            )
        },
    ]
}
