//! A bench with forces, position and stops behind a field box: every report is accounted for, and under any fault of box,
//! line or bench, the drive is silent in time and the recording remains readable (FAULTS.md, row 41).

use std::path::Path;

use config::Config;
use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::host::ConverterDirection;
use mock_hw::serial::ForceFault;
use mock_hw::world_clock::WorldPace;
use mock_world::plant::LoadedAxis;
use mock_world::scenario::{Scenario, built_in};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use safety::{SafetyState, Trip};
use sources::LineFaults;

use crate::campaign;
use crate::rig::{Rig, amplitudes, config, rest_s};
use crate::safe::quantiles_ms;

fn scenario() -> Scenario {
    built_in("field-box").unwrap()
}

/// Returns a bench behind a box that may be silent for this long, with `more` in its description.
pub fn box_config(silence_s: &str, extra_lines: &str) -> Config {
    config(&[
        ("silence_s = 0.25", &format!("silence_s = {silence_s}")),
        (
            "port = \"/dev/ttyUSB0\"",
            "source = \"field-box\"\nfield_box = { newtons_per_full_scale = [20.0, 20.0] }",
        ),
        ("[encoder]\n", "[encoder]\nsource = \"field-box\"\n"),
        ("backend = \"none\"", "backend = \"field-box\""),
        (
            "[sound]\n",
            &format!("[field_box]\nport = \"/dev/ttyACM0\"\n{extra_lines}\n[sound]\n"),
        ),
    ])
}

fn bench() -> Config {
    box_config("0.05", "")
}

/// Fault 41.
#[test]
fn lost_repeated_and_torn_reports_are_counted_exactly_and_each_other_one_is_there() {
    let mut rig = Rig::new(scenario(), box_config("0.25", ""), None);
    rig.pass(1.0);
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let mut injected = LineFaults::default();
    let rows_before = rig.record.force.len();
    let began_ns = rig.apparatus.now_ns();
    while rig.apparatus.now_ns() < began_ns + 10_000_000_000 {
        // An injected fault acts on the next report; a tick has more than one report.
        match rng.random_range(0..60) {
            0 => {
                rig.apparatus.faults().force(ForceFault::Drop(1));
                injected.lost += 1;
            }
            1 => {
                rig.apparatus.faults().force(ForceFault::Repeat(1));
                injected.repeated += 1;
            }
            2 => {
                rig.apparatus.faults().force(ForceFault::Corrupt(1));
                injected.corrupt += 1;
            }
            _ => {}
        }
        rig.pass(1e-9);
    }
    rig.pass(0.1);
    let counts = rig.bench.gauges.field.get().unwrap().force;
    assert!(
        injected.lost > 200 && injected.corrupt > 200,
        "{injected:?}"
    );
    assert_eq!(counts, injected);
    let rows = &rig.record.force[rows_before..];
    assert!(rows.is_sorted_by(|a, b| a.time_s < b.time_s));
    let expected = 10.1 * 4000.0 * (1.0 + 30e-6) - (injected.lost + injected.corrupt) as f64;
    assert!(
        (rows.len() as f64 - expected).abs() < 8.0,
        "{} of {expected}",
        rows.len()
    );
    // A thousand positions a second, on the same clock.
    let positions = rig.record.position.len() as f64 / 11.1;
    assert!((positions - 1000.0).abs() < 30.0, "{positions} a second");
}

/// Fault 24.
#[test]
fn forces_of_a_box_are_placed_to_a_tenth_of_a_millisecond() {
    let mut scenario = scenario();
    scenario.force_sensor.clock_ppm = -80.0;
    scenario.converter.clock_ppm = 40.0;
    let mut rig = Rig::new(scenario, box_config("0.25", ""), None);
    rig.pass(20.0);
    let truth_s = |k: usize| k as f64 / 4000.0 / (1.0 - 80e-6) * (1.0 + 40e-6);
    let rows = rig.record.force.iter().enumerate();
    let error_s = rows.map(|(k, row)| (row.time_s, (row.time_s - truth_s(k)).abs()));
    let late = error_s.filter(|(time_s, _)| *time_s > 10.0);
    let worst_s = late.map(|(_, error_s)| error_s).fold(0.0, f64::max);
    assert!(worst_s < 1e-4, "{worst_s} s");
}

/// A fault, and a check of the bench's report on it.
type Case = (&'static str, fn(&Rig), fn(&Trip) -> bool);

fn names_the_port(trip: &Trip) -> bool {
    trip.to_string().contains("field_box.port in bench.toml")
}

const CASES: [Case; 13] = [
    (
        "converter silent",
        |rig| rig.apparatus.faults().force(ForceFault::Silent(true)),
        |trip| *trip == Trip::ForceSilent,
    ),
    (
        "cable out",
        |rig| rig.apparatus.faults().unplug_force(),
        names_the_port,
    ),
    (
        "another device on its port",
        |rig| rig.apparatus.faults().force(ForceFault::OtherDevice(true)),
        |trip| names_the_port(trip) || matches!(trip, Trip::ForceNonsense { .. }),
    ),
    (
        "every report torn",
        |rig| rig.apparatus.faults().force(ForceFault::Corrupt(100_000)),
        |trip| names_the_port(trip) || matches!(trip, Trip::ForceNonsense { .. }),
    ),
    (
        "a channel at its end",
        |rig| rig.apparatus.faults().force(ForceFault::Saturated(true)),
        |trip| matches!(trip, Trip::ForceSaturated | Trip::ForceLimit { .. }),
    ),
    (
        "4 N on the plate",
        |rig| rig.apparatus.masses().place(LoadedAxis::Normal, 0.4),
        |trip| matches!(trip, Trip::ForceLimit { .. }),
    ),
    (
        "4 N back along the plate",
        |rig| rig.apparatus.masses().place(LoadedAxis::Lateral, -0.4),
        |trip| matches!(trip, Trip::LateralForceLimit { .. }),
    ),
    (
        "e-stop pressed",
        |rig| rig.apparatus.faults().press_estop(true),
        |trip| *trip == Trip::EmergencyStop,
    ),
    (
        "e-stop cut",
        |rig| rig.apparatus.faults().cut_estop_wire(true),
        |trip| *trip == Trip::EmergencyStop,
    ),
    (
        "converter silent, and the e-stop pressed",
        |rig| {
            rig.apparatus.faults().force(ForceFault::Silent(true));
            rig.apparatus.faults().press_estop(true);
        },
        |trip| *trip == Trip::EmergencyStop,
    ),
    (
        "4 N while most reports are lost or torn",
        |rig| {
            for _ in 0..20 {
                rig.apparatus.faults().force(ForceFault::Drop(1));
                rig.apparatus.faults().force(ForceFault::Corrupt(1));
            }
            rig.apparatus.masses().place(LoadedAxis::Normal, 0.4);
        },
        |trip| matches!(trip, Trip::ForceLimit { .. }),
    ),
    (
        "cable out, and 4 N on the plate",
        |rig| {
            rig.apparatus.faults().unplug_force();
            rig.apparatus.masses().place(LoadedAxis::Normal, 0.4);
        },
        names_the_port,
    ),
    (
        "cable out, and the e-stop pressed",
        |rig| {
            rig.apparatus.faults().unplug_force();
            rig.apparatus.faults().press_estop(true);
        },
        names_the_port,
    ),
];

/// Fault 41.
/// Hazard 20.
#[test]
fn whatever_the_box_does_the_drive_is_silent_in_time_and_what_was_recorded_is_kept() {
    for (name, inject, is_expected) in CASES {
        let mut rig = Rig::new(scenario(), bench(), None);
        rig.pass(0.1);
        rig.stops_recorded(name, inject, is_expected);
    }
}

/// Fault 41.
#[test]
fn a_box_that_cannot_be_used_from_the_start_arms_nothing_and_says_which_line_to_change() {
    type Unusable = (&'static str, fn(&Rig), &'static str);
    let cases: [Unusable; 3] = [
        (
            "",
            |rig| rig.apparatus.faults().force(ForceFault::OtherDevice(true)),
            "field_box.port",
        ),
        (
            "",
            |rig| rig.apparatus.faults().force(ForceFault::Corrupt(1_000_000)),
            "field_box.port",
        ),
        (
            "serial = \"E661410403002A21\"",
            |_| {},
            "field_box.serial = \"E661410403002A21\" in bench.toml",
        ),
    ];
    for (extra_lines, inject, words) in cases {
        let mut rig = Rig::new(scenario(), box_config("0.05", extra_lines), None);
        inject(&rig);
        let trip = loop {
            if let SafetyState::Tripped { trip } = rig.tick() {
                break trip.to_string();
            }
            assert!(rig.apparatus.now_ns() < 2_100_000_000, "{words}");
        };
        assert!(trip.contains(words), "{words}: {trip}");
        for _ in 0..3 {
            rig.bench.drive.rearm();
            rig.drive();
            for _ in 0..600 {
                assert!(matches!(rig.tick(), SafetyState::Tripped { .. }), "{words}");
            }
        }
        assert_eq!(rig.bench.drive.programs(), 0, "{words}");
    }
}

/// Fault 41.
#[test]
fn a_box_that_answers_late_is_waited_for() {
    let mut rig = Rig::new(scenario(), bench(), None);
    rig.apparatus.faults().force(ForceFault::OtherDevice(true));
    rig.pass(1.0);
    rig.apparatus.faults().force(ForceFault::OtherDevice(false));
    rig.pass(0.5);
    rig.drive();
    rig.pass(0.3);
    assert!(rig.bench.drive.sounds());
    let identity = rig.bench.field_box.as_ref().unwrap().in_words().unwrap();
    assert!(identity.contains("513D0073696D756C"), "{identity}");
}

/// Returns a rig whose amplifier's one-shot waits for ten seconds, with the truth in `folder`.
fn slow_one_shot_rig(folder: &Path) -> Rig {
    let mut scenario = scenario();
    scenario.amplifier.one_shot_s = 10.0;
    let apparatus = Apparatus::new(ApparatusConfig {
        truth_path: Some(folder.to_owned()),
        ..ApparatusConfig::new(scenario, 1, WorldPace::Stepped)
    });
    let mut rig = Rig::with_apparatus(apparatus.unwrap(), bench(), None);
    rig.pass(0.1);
    rig
}

/// A freeze of the program, in true time, s.
struct Freeze {
    at_s: f64,
    for_s: f64,
}

/// The amplifier's one-shot waits for ten seconds and the card repeats its buffer: only the box stops the plate.
///
/// Faults 7, 41.
/// Hazard 15.
#[test]
fn a_bench_frozen_at_random_moments_is_stopped_by_the_box_alone_within_a_tenth_of_a_second() {
    let count = campaign::repeats("FRICTION_BENCH_BOX_FREEZES", 12);
    let folder = tempfile::tempdir().unwrap();
    let mut rig = slow_one_shot_rig(folder.path());
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let mut freezes = Vec::new();
    for number in 0..count {
        rig.drive();
        rig.pass(rng.random_range(0.25..0.5));
        assert!(rig.bench.drive.sounds());
        let for_s = if number % 2 == 0 { 0.12 } else { 0.4 };
        freezes.push(Freeze {
            at_s: rig.apparatus.now_ns() as f64 * 1e-9,
            for_s,
        });
        rig.freeze(for_s);
        for _ in 0..600 {
            rig.tick();
        }
        let state = rig.tick();
        assert!(matches!(state, SafetyState::Tripped { .. }), "{state:?}");
        assert!(!rig.bench.drive.sounds(), "drives by itself");
        rig.bench.drive.rearm();
        rig.pass(0.1);
    }
    let Rig { apparatus, .. } = rig;
    apparatus.finish().unwrap();
    let truth = amplitudes(folder.path());
    let to_rest = freezes.iter().map(|freeze| {
        let rest_s = rest_s(&truth, freeze.at_s, freeze.for_s);
        assert!((0.07..0.1).contains(&rest_s), "moves for {rest_s} s");
        rest_s
    });
    let to_rest = to_rest.collect();
    let text = format!(
        "median / 99 % / worst: plate at rest {}",
        quantiles_ms(to_rest)
    );
    campaign::report("stop: field box, program frozen", count, &text);
}

/// The amplifier's one-shot waits for ten seconds. The watch that should stop the drive hangs when the cable is
/// unplugged.
///
/// Fault 41.
/// Hazard 15.
#[test]
fn a_cable_that_comes_out_while_the_watch_hangs_is_stopped_by_the_box_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = slow_one_shot_rig(folder.path());
    rig.drive();
    rig.pass(0.5);
    let at_s = rig.apparatus.now_ns() as f64 * 1e-9;
    rig.apparatus.faults().unplug_force();
    rig.apparatus
        .faults()
        .halt_audio(ConverterDirection::Input, true);
    rig.freeze(0.3);
    let Rig { apparatus, .. } = rig;
    apparatus.finish().unwrap();
    let truth = amplitudes(folder.path());
    let rest_s = rest_s(&truth, at_s, f64::INFINITY);
    assert!((0.07..0.1).contains(&rest_s), "moves for {rest_s} s");
}
