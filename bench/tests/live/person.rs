//! The driving time of an hour and the dead-man switch, on the whole bench (FAULTS.md, row 42).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use mock_world::scenario::Scenario;
use recording::RecordingReader;
use safety::{SafetyState, Trip};
use sources::Lines;

use crate::rig::{Level, Rig, apparatus, config};

/// Ticks until the watch trips, at most `within_s`; returns the trip and its time, s.
fn trip(rig: &mut Rig, within_s: f64) -> (Trip, f64) {
    let begun_ns = rig.apparatus.now_ns();
    loop {
        let state = rig.tick();
        let since_s = (rig.apparatus.now_ns() - begun_ns) as f64 * 1e-9;
        if let SafetyState::Tripped { trip } = state {
            return (trip, since_s);
        }
        assert!(
            since_s < within_s,
            "nothing stopped the drive within {within_s} s"
        );
    }
}

/// Ticks until the drive is silent; returns the time that took, s.
fn silent_s(rig: &mut Rig) -> f64 {
    let begun_ns = rig.apparatus.now_ns();
    while rig.bench.drive.sounds() {
        rig.tick();
    }
    (rig.apparatus.now_ns() - begun_ns) as f64 * 1e-9
}

/// Requires half a second without the drive restarting.
fn stays_silent(rig: &mut Rig) {
    let until_ns = rig.apparatus.now_ns() + 500_000_000;
    while rig.apparatus.now_ns() < until_ns {
        assert!(matches!(rig.tick(), SafetyState::Tripped { .. }));
        assert!(!rig.bench.drive.sounds());
    }
}

fn kept_s(folder: &std::path::Path) -> f64 {
    let reader = RecordingReader::open(folder).unwrap();
    reader.frames() as f64 / f64::from(reader.format().sample_rate_hz)
}

/// Fault 42.
/// Hazards 4, 5, 6.
#[test]
fn an_hours_driving_time_that_is_used_up_stops_the_whole_bench_and_keeps_what_was_recorded() {
    let dose = [
        ("silence_s = 0.25", "silence_s = 0.05"),
        ("ramp_s = 0.05", "ramp_s = 0.05\ndriving_s_per_hour = 2.0"),
    ];
    let mut rig = Rig::new(Scenario::default(), config(&dose), None);
    rig.drive();
    let folder = rig.begin("dose");
    let (cause, after_s) = trip(&mut rig, 2.5);
    let Trip::Dose {
        driven_s, wait_s, ..
    } = cause
    else {
        panic!("{cause}")
    };
    assert!(
        (driven_s - 2.0).abs() < 0.01 && (2.0..2.1).contains(&after_s),
        "{driven_s} {after_s}"
    );
    assert!((3590.0..3600.0).contains(&wait_s), "{wait_s}");
    assert!(silent_s(&mut rig) < 0.01);
    stays_silent(&mut rig);
    // The operator re-arms too early.
    rig.bench.drive.rearm();
    rig.drive();
    let (cause, _) = trip(&mut rig, 0.1);
    assert!(matches!(cause, Trip::Dose { .. }), "{cause}");
    rig.end();
    assert!(kept_s(&folder) > 1.9);
}

/// Fault 42.
/// Hazard 15.
#[test]
fn a_dead_man_switch_that_is_released_silences_the_whole_bench_in_time() {
    let switch = [
        ("silence_s = 0.25", "silence_s = 0.05"),
        ("[safety]\n", "[safety]\ndead_man = \"button\"\n"),
    ];
    let switch_closed = Arc::new(AtomicBool::new(false));
    let lines = Lines {
        dead_man: Some(Box::new(Level(Arc::clone(&switch_closed)))),
        ..Lines::default()
    };
    let mut rig = Rig::with_lines(apparatus(Scenario::default()), config(&switch), lines);
    let hold = |rig: &mut Rig, closed: bool| {
        switch_closed.store(closed, Ordering::Relaxed);
        rig.pass(0.1);
    };
    hold(&mut rig, false);
    hold(&mut rig, true);
    rig.drive();
    rig.pass(0.3);
    let folder = rig.begin("held");
    rig.pass(0.5);
    assert!(rig.bench.drive.sounds());

    switch_closed.store(false, Ordering::Relaxed);
    let (cause, after_s) = trip(&mut rig, 0.3);
    assert_eq!(cause, Trip::DeadManReleased);
    assert!((0.2..0.205).contains(&after_s), "{after_s} s");
    let ramp_s = silent_s(&mut rig);
    assert!(ramp_s < 0.01, "{ramp_s} s");
    stays_silent(&mut rig);

    // Neither a press alone nor re-arming alone starts the drive.
    switch_closed.store(true, Ordering::Relaxed);
    stays_silent(&mut rig);
    switch_closed.store(false, Ordering::Relaxed);
    rig.bench.drive.rearm();
    rig.pass(0.1);
    rig.drive();
    let (cause, _) = trip(&mut rig, 0.1);
    assert!(matches!(cause, Trip::DeadManNotHeld { .. }), "{cause}");
    rig.bench.drive.rearm();
    hold(&mut rig, true);
    rig.drive();
    rig.pass(0.3);
    assert!(rig.bench.drive.sounds());
    rig.end();
    assert!(kept_s(&folder) > 0.6);
}
