//! A drive that is alive although it must be off.

use super::*;

/// Fault 19.
/// Hazard 17.
#[test]
fn a_drive_that_is_alive_while_disarmed_is_an_alarm() {
    let mut rig = Rig::new(SafetyLines::default());
    rig.pass(60, |rig| rig.read_back(12.0));
    assert!(matches!(rig.trip(), Some(Trip::AliveWhileDisarmed { .. })));
}

/// Fault 19.
/// Hazard 17.
#[test]
fn a_drive_that_is_alive_after_a_stop_is_an_alarm_that_takes_the_place_of_the_reason() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.ask.send(SafetyCommand::Trip(Trip::Operator));
    rig.card.commanded_v.set(0.0);
    // For as long as the ramp and the loop may take, the reason stays.
    rig.pass(100, |rig| rig.read_back(12.0));
    assert_eq!(rig.trip(), Some(Trip::Operator));
    rig.pass(60, |rig| rig.read_back(12.0));
    let alive = Trip::AliveWhileDisarmed { measured_v: 12.0 };
    assert_eq!(rig.trip(), Some(alive.clone()));
    let words = alive.to_string();
    for word in ["finger off the plate", "at the mains", "12.0 V"] {
        assert!(words.contains(word), "{words}");
    }
    // The alarm latches, and re-arming brings it back for as long as the drive is alive.
    rig.pass(500, |_| ());
    assert_eq!(rig.trip(), Some(alive));
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(60, |rig| rig.read_back(9.0));
    assert_eq!(
        rig.trip(),
        Some(Trip::AliveWhileDisarmed { measured_v: 9.0 })
    );
}

#[test]
fn a_stop_after_which_nothing_is_read_back_keeps_its_reason() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.ask.send(SafetyCommand::Trip(Trip::Operator));
    rig.card.commanded_v.set(0.0);
    rig.pass(1000, |rig| rig.read_back(0.4));
    assert_eq!(rig.trip(), Some(Trip::Operator));

    // A reading from before the stop does not count.
    let mut rig = Rig::armed(SafetyLines::default());
    let old_reading = rig.signals.readback.get().unwrap();
    rig.ask.send(SafetyCommand::Trip(Trip::Operator));
    rig.pass(1000, |rig| rig.signals.readback.set(old_reading));
    assert_eq!(rig.trip(), Some(Trip::Operator));
}

/// Fault 19.
/// Hazard 17.
#[test]
fn a_drive_that_is_alive_while_nothing_is_played_stops_with_what_to_do() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.card.commanded_v.set(0.0);
    rig.pass(300, |_| ());
    assert_eq!(rig.trip(), None);
    rig.pass(50, |rig| rig.read_back(5.0));
    let Some(trip @ Trip::AliveUndriven { .. }) = rig.trip() else {
        panic!("{:?}", rig.trip());
    };
    assert!(trip.to_string().contains("finger off the plate"), "{trip}");
}
