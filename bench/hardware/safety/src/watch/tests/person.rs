//! Protection of the person at the plate: driving time, dead-man switch.

use super::*;
use crate::dead_man::Hold;
use crate::dose::DoseLeft;
use crate::sliding_hour::{DrivenSpan, SlidingHour};

const S: u64 = 1000;

fn allow(rig: &Rig, limit_s: f64, spans: &[(i64, i64)]) {
    let mut hour = SlidingHour::default();
    for &(start_s, end_s) in spans {
        hour.add(DrivenSpan {
            start_ns: start_s * 1_000_000_000,
            end_ns: end_s * 1_000_000_000,
        });
    }
    let allowance = Allowance {
        earlier_driving: hour,
        ..Allowance::per_hour(limit_s)
    };
    rig.ask.send(SafetyCommand::Allow(allowance));
}

fn dose_left(rig: &Rig) -> DoseLeft {
    rig.signals.dose.get().unwrap()
}

/// Plays the drive at a voltage.
fn sound(rig: &mut Rig, volts: f64, ms: u64) {
    rig.card.commanded_v.set(volts);
    rig.pass(ms, |_| ());
}

/// Fault 42.
/// Hazards 4, 5, 6.
#[test]
fn a_dose_that_is_used_up_stops_and_says_when_to_go_on() {
    let mut rig = Rig::armed(SafetyLines::default());
    allow(&rig, 20.0, &[]);
    sound(&mut rig, 20.0, 19 * S);
    assert_eq!(rig.trip(), None);
    for _ in 0..200 {
        if rig.trip().is_none() {
            rig.pass(10, |_| ());
        }
    }
    let Some(Trip::Dose {
        driven_s, wait_s, ..
    }) = rig.trip()
    else {
        panic!("{:?}", rig.trip())
    };
    assert!((driven_s - 20.0).abs() < 0.01, "{driven_s}");
    // A tenth of it is free an hour after its first two seconds.
    assert!((wait_s - (3600.0 - 18.0)).abs() < 0.1, "{wait_s}");
    sound(&mut rig, 0.0, S);
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::Dose { .. })), "not yet");
}

/// Fault 42.
#[test]
fn what_was_driven_before_the_program_started_counts() {
    let mut rig = Rig::new(SafetyLines::default());
    allow(&rig, 600.0, &[(-1000, -500), (-400, -301)]);
    rig.pass(10, |_| ());
    assert!((dose_left(&rig).left_s - 1.0).abs() < 1e-6);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    let Some(Trip::Dose { wait_s, .. }) = rig.trip() else {
        panic!("armed with a second left")
    };
    // Nine more seconds of the earliest drive must fall out of the hour.
    assert!((wait_s - (3600.0 - 1000.0 + 9.0)).abs() < 0.1, "{wait_s}");
}

#[test]
fn the_faint_tone_costs_nothing_and_each_drive_that_is_felt_does() {
    let mut rig = Rig::new(SafetyLines::default());
    allow(&rig, 100.0, &[]);
    sound(&mut rig, 2.0, 5 * S);
    assert_eq!(dose_left(&rig).left_s, 100.0);
    // A modulation that falls below the faint level.
    for _ in 0..60 {
        sound(&mut rig, 20.0, 130);
        sound(&mut rig, 1.0, 36);
    }
    let used_s = 100.0 - dose_left(&rig).left_s;
    assert!((9.8..=10.0).contains(&used_s), "{used_s}");
    // A plate that is driven without a command.
    sound(&mut rig, 0.0, 2 * S);
    let previous_s = dose_left(&rig).left_s;
    rig.pass(3 * S, |rig| rig.read_back(10.0));
    let used_s = previous_s - dose_left(&rig).left_s;
    assert!((used_s - 3.0).abs() < 0.01, "{used_s}");
}

#[test]
fn each_span_is_reported_from_its_first_moment() {
    let mut rig = Rig::armed(SafetyLines::default());
    let (spans, reports) = crossbeam_channel::unbounded();
    let allowance = Allowance {
        spans: Some(spans),
        ..Allowance::per_hour(100.0)
    };
    sound(&mut rig, 0.0, 2 * S);
    rig.ask.send(SafetyCommand::Allow(allowance));
    rig.pass(S, |_| ());
    assert_eq!(reports.len(), 0);
    sound(&mut rig, 20.0, 1);
    let first = reports.recv().unwrap();
    assert_eq!(first.start_ns, first.end_ns);
    sound(&mut rig, 20.0, 10 * S);
    sound(&mut rig, 0.0, 2 * S);
    let spans: Vec<DrivenSpan> = reports.try_iter().collect();
    assert!(spans.iter().all(|span| span.start_ns == first.start_ns));
    let last = spans.last().unwrap();
    let length_s = (last.end_ns - last.start_ns) as f64 * 1e-9;
    assert!((length_s - 10.0).abs() < 0.01, "{length_s}");
}

/// The disk under the account hangs.
///
/// Faults 27, 42.
/// Hazards 4, 5, 6.
#[test]
fn a_drive_whose_time_nobody_keeps_stops_and_all_of_it_is_kept_once_the_disk_is_back() {
    let mut rig = Rig::armed(SafetyLines::default());
    let (spans, reports) = crate::span_reports();
    let allowance = Allowance {
        spans: Some(spans),
        ..Allowance::per_hour(100.0)
    };
    sound(&mut rig, 0.0, 2 * S);
    rig.ask.send(SafetyCommand::Allow(allowance));
    let mut driven_s = 0.0;
    sound(&mut rig, 20.0, 3500);
    assert_eq!(rig.trip(), None, "it may be slow");
    while rig.trip().is_none() && driven_s < 10.0 {
        sound(&mut rig, 20.0, 10);
        driven_s += 0.01;
    }
    let Some(Trip::Fault { message }) = rig.trip() else {
        panic!("{:?}", rig.trip())
    };
    assert!(message.contains("driving time"), "{message}");
    assert!(driven_s < 1.0, "{driven_s}");
    sound(&mut rig, 0.0, 100);
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert!(rig.trip().is_some(), "not while it hangs");
    let used_s = 100.0 - dose_left(&rig).left_s;
    let mut last: Option<DrivenSpan> = None;
    for _ in 0..3 {
        last = reports.try_iter().last().or(last);
        rig.pass(10, |_| ());
    }
    let last = last.unwrap();
    let kept_s = (last.end_ns - last.start_ns) as f64 * 1e-9;
    assert!(kept_s >= used_s, "{kept_s} s of {used_s}");
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert_eq!(rig.trip(), None);
}

/// The disk under the record of the plate's warmth hangs.
///
/// Faults 27, 42.
/// Hazard 4.
#[test]
fn a_plate_that_is_warmer_than_its_record_tells_stops_and_is_not_armed() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.ask.send(SafetyCommand::Warm { rise_k: 3.0 });
    rig.signals.kept_rise_k.set(3.5);
    rig.pass(10, |_| ());
    rig.signals.kept_rise_k.set(2.6);
    rig.pass(10, |_| ());
    assert_eq!(rig.trip(), None, "within what it may be behind");
    rig.signals.kept_rise_k.set(2.4);
    rig.pass(10, |_| ());
    let Some(Trip::Fault { message }) = rig.trip() else {
        panic!("{:?}", rig.trip())
    };
    assert!(message.contains("temperature cannot be saved"), "{message}");
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert!(rig.trip().is_some(), "not while it hangs");
    rig.signals.kept_rise_k.set(3.5);
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert_eq!(rig.trip(), None);
}

/// Dead-man line at a level set by the test.
struct Held(Arc<AtomicBool>);

impl crate::InputLine for Held {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        Ok(self.0.load(Ordering::Relaxed))
    }
}

/// Returns a bench with a dead-man switch that releases in a fifth of a second, and the switch.
fn with_switch() -> (Rig, Arc<AtomicBool>) {
    let pressed = Arc::new(AtomicBool::new(false));
    let lines = SafetyLines {
        dead_man: Some(Box::new(Held(Arc::clone(&pressed)))),
        ..SafetyLines::default()
    };
    let limits = SafetyLimits {
        dead_man_release_ns: Some(200_000_000),
        ..LIMITS
    };
    (Rig::with_limits(limits, lines), pressed)
}

fn arm(rig: &mut Rig) -> SafetyState {
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    rig.watch.state.clone()
}

/// Fault 42.
/// Hazard 15.
#[test]
fn a_released_dead_man_switch_stops_and_wants_a_press_and_the_operator() {
    let (mut rig, pressed) = with_switch();
    rig.pass(100, |_| ());
    pressed.store(true, Ordering::Relaxed);
    rig.pass(100, |_| ());
    assert_eq!(arm(&mut rig), SafetyState::Armed);
    sound(&mut rig, 20.0, 2 * S);
    pressed.store(false, Ordering::Relaxed);
    rig.pass(190, |_| ());
    assert_eq!(rig.trip(), None);
    let kills = rig.card.kills();
    rig.pass(20, |_| ());
    assert_eq!(rig.trip(), Some(Trip::DeadManReleased));
    assert!(rig.card.kills() > kills);

    sound(&mut rig, 0.0, S);
    let unheld = Trip::DeadManNotHeld { hold: Hold::Press };
    assert_eq!(arm(&mut rig), SafetyState::Tripped { trip: unheld });
    pressed.store(true, Ordering::Relaxed);
    rig.pass(S, |_| ());
    assert!(rig.trip().is_some(), "a press alone starts nothing");
    assert_eq!(arm(&mut rig), SafetyState::Armed);
}

/// Fault 42.
/// Hazard 15.
#[test]
fn a_dead_man_switch_that_does_not_open_arms_nothing() {
    let (mut rig, pressed) = with_switch();
    pressed.store(true, Ordering::Relaxed);
    // The rig began with an open line.
    rig.watch.dead_man = Some(DeadMan::new(200_000_000));
    rig.pass(S, |_| ());
    assert_eq!(rig.signals.hold.get(), Some(Hold::Release));
    let stuck = Trip::DeadManNotHeld {
        hold: Hold::Release,
    };
    assert_eq!(arm(&mut rig), SafetyState::Tripped { trip: stuck });
}

/// Hazard 15.
#[test]
fn a_drive_that_begins_without_a_new_press_is_stopped_although_the_bench_is_armed() {
    let (mut rig, pressed) = with_switch();
    rig.pass(100, |_| ());
    pressed.store(true, Ordering::Relaxed);
    rig.pass(100, |_| ());
    assert_eq!(arm(&mut rig), SafetyState::Armed);
    sound(&mut rig, 20.0, S);
    sound(&mut rig, 0.0, S);
    assert_eq!(rig.trip(), None);
    sound(&mut rig, 20.0, 2);
    let stuck = Trip::DeadManNotHeld {
        hold: Hold::Release,
    };
    assert_eq!(rig.trip(), Some(stuck));
}

#[test]
fn a_dead_man_switch_that_is_not_wired_is_never_held() {
    let limits = SafetyLimits {
        dead_man_release_ns: Some(200_000_000),
        ..LIMITS
    };
    let mut rig = Rig::with_limits(limits, SafetyLines::default());
    rig.pass(S, |_| ());
    assert!(matches!(arm(&mut rig), SafetyState::Tripped { .. }));
}
