//! Lost devices, which keep a trip latched.

use super::*;
use crate::losses::{LostDevice, RearmObstacle};

/// Fault 5.
/// Fault 21.
#[test]
fn a_lost_device_outlasts_the_operators_rearming() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.ask.send(SafetyCommand::Trip(Trip::ForceSilent));
    rig.signals.losses.report(LostDevice::ForceSensor);
    rig.card.commanded_v.set(0.0);
    rig.pass(100, |_| ());
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(100, |_| ());
    assert_eq!(rig.trip(), Some(Trip::ForceSilent));
    let obstacle = rig.signals.rearm_obstacle();
    assert_eq!(obstacle, Some(RearmObstacle::Lost(LostDevice::ForceSensor)));
}

/// Fault 5.
#[test]
fn a_lost_card_latches_armed_or_not() {
    for mut rig in [
        Rig::armed(SafetyLines::default()),
        Rig::new(SafetyLines::default()),
    ] {
        rig.card.commanded_v.set(0.0);
        rig.card.lost.store(true, Ordering::Relaxed);
        rig.pass(100, |_| ());
        assert_eq!(rig.trip(), Some(Trip::AudioLost));
        rig.ask.send(SafetyCommand::Rearm);
        rig.pass(100, |_| ());
        assert_eq!(rig.trip(), Some(Trip::AudioLost));
    }
}
