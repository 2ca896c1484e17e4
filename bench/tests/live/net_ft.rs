//! Forces from the network: every datagram is accounted for, and under any fault of network or sensor the drive is silent
//! in time and the recording remains readable (FAULTS.md, row 40).

use config::Config;
use mock_hw::serial::ForceFault;
use mock_world::plant::LoadedAxis;
use mock_world::scenario::{Scenario, built_in};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::manifest::EventKind;
use safety::{SafetyState, Trip};
use sources::LineFaults;

use crate::rig::{Rig, config, events};

fn scenario() -> Scenario {
    built_in("net-ft").unwrap()
}

/// Returns a bench with a Net F/T that may be silent for this long.
fn bench(silence_s: &str) -> Config {
    config(&[
        ("silence_s = 0.25", &format!("silence_s = {silence_s}")),
        (
            "port = \"/dev/ttyUSB0\"",
            "source = \"netft\"\nnetft = { counts_per_n = 1e6 }",
        ),
    ])
}

/// Fault 40.
#[test]
fn lost_late_repeated_and_torn_datagrams_at_7_khz_are_counted_exactly() {
    let mut rig = Rig::new(scenario(), bench("0.25"), None);
    rig.pass(1.0);
    let folder = rig.begin("counted");
    let mut rng = ChaCha8Rng::seed_from_u64(40);
    let mut injected = LineFaults::default();
    let rows_before = rig.record.force.len();
    let began_ns = rig.apparatus.now_ns();
    // A tick has 2.3 records; each kind of fault hits one record in a hundred.
    while rig.apparatus.now_ns() < began_ns + 10_000_000_000 {
        match rng.random_range(0..43) {
            0 => {
                rig.apparatus.faults().force(ForceFault::Drop(1));
                injected.lost += 1;
            }
            1 => {
                rig.apparatus.faults().force(ForceFault::Reorder(1));
                injected.reordered += 1;
            }
            2 => {
                rig.apparatus.faults().force(ForceFault::Repeat(1));
                injected.repeated += 1;
            }
            3 => {
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
        injected.lost > 500 && injected.reordered > 500,
        "{injected:?}"
    );
    assert_eq!(counts, injected);
    // Each reading that is not lost, torn or overtaken is there, once, in order.
    let rows = &rig.record.force[rows_before..];
    assert!(rows.is_sorted_by(|a, b| a.time_s < b.time_s));
    let missing = injected.lost + injected.corrupt + injected.reordered;
    let expected = 10.1 * 7000.0 * (1.0 + 30e-6) - missing as f64;
    assert!(
        (rows.len() as f64 - expected).abs() < 8.0,
        "{} of {expected}",
        rows.len()
    );
    rig.end();
    let losses = events(&folder);
    let losses = losses
        .iter()
        .filter(|event| event.0 == EventKind::ForceLost);
    let words: Vec<_> = losses.map(|event| event.3.as_str()).collect();
    assert!(!words.is_empty() && words.iter().any(|words| words.contains("overtaken")));
}

/// Fault 24.
#[test]
fn a_sensor_in_the_network_is_placed_to_a_tenth_of_a_millisecond() {
    let mut scenario = scenario();
    scenario.force_sensor.clock_ppm = -80.0;
    scenario.converter.clock_ppm = 40.0;
    let mut rig = Rig::new(scenario, bench("0.25"), None);
    rig.pass(10.0);
    // All samples arrive, from the first one at time zero on.
    let truth_s = |k: usize| k as f64 / 7000.0 / (1.0 - 80e-6) * (1.0 + 40e-6);
    let rows = rig.record.force.iter().enumerate();
    let error_s = rows.map(|(k, row)| (row.time_s, (row.time_s - truth_s(k)).abs()));
    let late = error_s.filter(|(time_s, _)| *time_s > 6.0);
    let worst_s = late.map(|(_, error_s)| error_s).fold(0.0, f64::max);
    assert!(worst_s < 1e-4, "{worst_s} s");
    assert!(
        rig.record.force.len() > 69_900,
        "{}",
        rig.record.force.len()
    );
    let drift_ppm = rig.bench.gauges.force_clock_ppm().unwrap();
    assert!((drift_ppm + 120.0).abs() < 20.0, "{drift_ppm} ppm");
}

/// A fault, and a check of the bench's report on it.
type Case = (&'static str, fn(&Rig), fn(&Trip) -> bool);

const CASES: [Case; 9] = [
    (
        "silent",
        |rig| rig.apparatus.faults().force(ForceFault::Silent(true)),
        |trip| *trip == Trip::ForceSilent,
    ),
    (
        "cable out",
        |rig| rig.apparatus.faults().unplug_force(),
        |trip| *trip == Trip::ForceSilent,
    ),
    (
        "gauge at its end",
        |rig| rig.apparatus.faults().force(ForceFault::Saturated(true)),
        |trip| matches!(trip, Trip::ForceSaturated | Trip::ForceLimit { .. }),
    ),
    (
        "a failure that the sensor reports",
        |rig| {
            rig.apparatus
                .faults()
                .force(ForceFault::Status(1 << 31 | 1 << 28))
        },
        |trip| matches!(trip, Trip::ForceNonsense { .. }),
    ),
    (
        "another device at its address",
        |rig| rig.apparatus.faults().force(ForceFault::OtherDevice(true)),
        |trip| matches!(trip, Trip::ForceNonsense { .. }),
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
        "4 N while half of the datagrams are lost, late or torn",
        |rig| {
            for _ in 0..100 {
                rig.apparatus.faults().force(ForceFault::Drop(1));
                rig.apparatus.faults().force(ForceFault::Corrupt(1));
                rig.apparatus.faults().force(ForceFault::Reorder(1));
            }
            rig.apparatus.masses().place(LoadedAxis::Normal, 0.4);
        },
        |trip| matches!(trip, Trip::ForceLimit { .. }),
    ),
    (
        "silent, and the e-stop pressed",
        |rig| {
            rig.apparatus.faults().force(ForceFault::Silent(true));
            rig.apparatus.faults().press_estop(true);
        },
        |trip| *trip == Trip::EmergencyStop,
    ),
];

/// Fault 40.
/// Hazard 20.
#[test]
fn whatever_the_network_does_the_drive_is_silent_in_time_and_what_was_recorded_is_kept() {
    for (name, inject, is_expected) in CASES {
        let mut rig = Rig::new(scenario(), bench("0.05"), None);
        rig.stops_recorded(name, inject, is_expected);
    }
}

/// Fault 40.
#[test]
fn a_network_that_comes_back_is_used_again_once_the_operator_has_rearmed() {
    let mut rig = Rig::new(scenario(), bench("0.05"), None);
    rig.drive();
    rig.pass(0.5);
    rig.apparatus.faults().force(ForceFault::Silent(true));
    while !matches!(rig.tick(), SafetyState::Tripped { .. }) {}
    let rows = rig.record.force.len();
    for _ in 0..6000 {
        rig.tick();
    }
    assert_eq!(rig.record.force.len(), rows, "silent");
    rig.apparatus.faults().force(ForceFault::Silent(false));
    for _ in 0..3000 {
        assert!(matches!(rig.tick(), SafetyState::Tripped { .. }));
    }
    assert!(rig.record.force.len() > rows + 3000);
    rig.bench.drive.rearm();
    rig.pass(0.1);
    assert!(!rig.bench.drive.sounds(), "rearming starts nothing");
    rig.drive();
    rig.pass(0.3);
    assert!(rig.bench.drive.sounds());
}

/// Fault 40.
#[test]
fn what_sends_no_reading_from_the_start_arms_nothing_for_longer_than_a_second() {
    for fault in [
        ForceFault::OtherDevice(true),
        ForceFault::Status(1 << 31 | 1 << 29),
        ForceFault::Silent(true),
    ] {
        let mut rig = Rig::new(scenario(), bench("0.05"), None);
        rig.apparatus.faults().force(fault);
        rig.drive();
        let trip = loop {
            if let SafetyState::Tripped { trip } = rig.tick() {
                break trip;
            }
            assert!(
                rig.apparatus.now_ns() < 1_050_000_000,
                "{fault:?}: driven on"
            );
        };
        let is_expected = match fault {
            ForceFault::Silent(_) => trip == Trip::ForceSilent,
            _ => matches!(trip, Trip::ForceNonsense { .. }),
        };
        assert!(is_expected, "{fault:?}: {trip}");
    }
}
