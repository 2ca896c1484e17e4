//! Stops that bypass the task that decides, and the trip of such a task that hangs.

use super::*;
use crate::drive_stop::DriveStop;

/// Loop of an e-stop, opened by a test.
#[derive(Clone, Default)]
struct Loop(Arc<AtomicBool>);

impl Loop {
    fn open(&self, open: bool) {
        self.0.store(open, Ordering::Relaxed);
    }
}

impl crate::safety_lines::InputLine for Loop {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        Ok(!self.0.load(Ordering::Relaxed))
    }
}

/// Hazard 15.
#[test]
fn a_kill_by_another_latches_armed_or_not() {
    for mut rig in [
        Rig::armed(SafetyLines::default()),
        Rig::new(SafetyLines::default()),
    ] {
        rig.card.kill();
        rig.pass(1, |_| ());
        assert_eq!(rig.trip(), Some(Trip::Killed));
        rig.card.commanded_v.set(0.0);
        rig.pass(100, |_| ());
        rig.ask.send(SafetyCommand::Rearm);
        rig.pass(100, |_| ());
        assert_eq!(rig.trip(), None, "its own kills are known to the watch");
    }
}

/// Fault 49.
/// Hazard 15.
#[test]
fn a_task_that_decides_and_hangs_trips_an_armed_bench_within_a_second() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.hangs = true;
    rig.pass(1000, |_| ());
    assert_eq!(rig.trip(), None);
    rig.pass(2, |_| ());
    assert!(
        matches!(rig.trip(), Some(Trip::Unresponsive { for_s }) if (1.0..1.01).contains(&for_s)),
        "{:?}",
        rig.trip()
    );
    assert!(rig.card.kills() > 0);

    // Once it responds again, the operator may continue.
    rig.hangs = false;
    rig.card.commanded_v.set(0.0);
    rig.pass(100, |_| ());
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(2000, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Armed);
}

/// Fault 49.
#[test]
fn a_task_that_hangs_beside_a_disarmed_bench_trips_nothing_and_has_a_second_from_arming() {
    let mut rig = Rig::new(SafetyLines::default());
    rig.hangs = true;
    rig.pass(5000, |_| ());
    assert_eq!(rig.trip(), None);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(900, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Armed);
    rig.pass(200, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::Unresponsive { .. })));
}

/// Fault 49.
/// Hazard 15.
#[test]
fn keys_that_are_not_read_any_more_trip_an_armed_bench() {
    let mut rig = Rig::armed(SafetyLines::default());
    let keys = DriveStop::new(rig.ask.clone(), rig.signals.clone(), || ());
    rig.pass(3000, |_| ());
    assert_eq!(rig.trip(), None, "nobody has read keys here");
    rig.pass(3000, |_| keys.hear());
    rig.pass(1000, |_| ());
    assert_eq!(rig.trip(), None);
    rig.pass(2, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::KeysUnread { for_s }) if (1.0..1.01).contains(&for_s)));
}

/// Fault 7.
/// Hazard 15.
#[test]
fn a_computer_that_was_suspended_does_not_go_on_as_if_nothing_had_been() {
    let mut rig = Rig::armed(SafetyLines::default());
    let sleep = |rig: &Rig, s: u64| {
        rig.signals
            .suspended_ns
            .store(s * 1_000_000_000, Ordering::Relaxed)
    };
    sleep(&rig, 1);
    rig.pass(10, |_| ());
    assert_eq!(rig.trip(), None);
    sleep(&rig, 3601);
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::Frozen { for_s: 3600.0 }));
    rig.card.commanded_v.set(0.0);
    rig.pass(100, |_| ());
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(100, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Armed);
}

/// Fault 49.
#[test]
fn a_stop_key_names_the_operator_and_can_be_rearmed() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.hangs = true;
    let card = rig.card.clone();
    let stop = DriveStop::new(rig.ask.clone(), rig.signals.clone(), move || card.kill());
    stop.trip(Trip::Operator);
    assert_eq!(rig.card.kills(), 1, "before the watch has looked");
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::Operator));
    // A kill that the watch has not yet counted.
    rig.card.kill();
    rig.card.commanded_v.set(0.0);
    rig.pass(100, |_| ());
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(100, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Disarmed);
    rig.card.kill();
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::Killed));
}

#[test]
fn a_stop_follows_the_bench_that_is_open() {
    let kills: [Arc<AtomicU64>; 2] = Default::default();
    let [first, second] = kills.each_ref().map(|kills| {
        let kills = Arc::clone(kills);
        DriveStop::new(Mailbox::default(), Arc::default(), move || {
            kills.fetch_add(1, Ordering::Relaxed);
        })
    });
    let key = DriveStop::default();
    key.kill();
    for bench in [first, second] {
        key.follow(&bench);
        key.clone().kill();
    }
    assert_eq!(kills.map(|kills| kills.load(Ordering::Relaxed)), [1, 1]);
}

/// Fault 17.
#[test]
fn a_pressed_estop_is_no_absence_of_the_watch() {
    let estop = Loop::default();
    let mut rig = Rig::armed(SafetyLines {
        estop: Some(Box::new(estop.clone())),
        ..SafetyLines::default()
    });
    estop.open(true);
    rig.card.commanded_v.set(0.0);
    rig.pass(8000, |_| ());
    assert_eq!(rig.trip(), Some(Trip::EmergencyStop));
    estop.open(false);
    rig.ask.send(SafetyCommand::Rearm);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(10, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Armed);
    let absence_ns = rig.signals.longest_away_ns.load(Ordering::Relaxed);
    assert_eq!(absence_ns, 1_000_000);
}

/// Hazard 15.
#[test]
fn a_drive_that_sounds_after_a_trip_is_killed_again() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.ask.send(SafetyCommand::Trip(Trip::Operator));
    rig.pass(1, |_| ());
    let kills = rig.card.kills();
    rig.pass(50, |_| ());
    assert!(rig.card.kills() > kills);
    rig.card.commanded_v.set(0.0);
    let kills = rig.card.kills();
    rig.pass(50, |_| ());
    assert_eq!(rig.card.kills(), kills, "a silent drive is left alone");
}

/// Regression test: a bench in simulated time that a signal ended was recorded as a failure of the program, since the
/// watch looked once more between the kill and the end.
#[test]
fn the_kill_of_a_bench_that_ends_is_no_failure() {
    let mut rig = Rig::armed(SafetyLines::default());
    let card = rig.card.clone();
    let stop = DriveStop::new(rig.ask.clone(), rig.signals.clone(), move || card.kill());
    stop.kill();
    assert_eq!(rig.card.kills(), 1);
    rig.card.commanded_v.set(0.0);
    rig.pass(100, |_| ());
    assert_eq!(rig.trip(), None);
}
