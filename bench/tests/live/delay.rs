//! The loop's delay, measured while the real tasks run on the simulated card.

use mock_world::scenario::Scenario;
use safety::{SafetyState, Trip};

use crate::rig::{DELAY_S, Rig, config};

/// Returns a bench with `delay_s` of additional drive delay on its card, for which the nominal delay was measured.
fn waiting(delay_s: f64) -> Rig {
    let mut scenario = Scenario::default();
    scenario.sound_layer.delay_s = delay_s;
    let mut config = config(&[("silence_s = 0.25", "silence_s = 0.05")]);
    config.safety.measured_delay_s = Some(DELAY_S);
    let mut rig = Rig::new(scenario, config, None);
    rig.drive();
    rig
}

/// Fault 16.
#[test]
fn the_delay_of_the_card_is_measured_at_the_first_rise() {
    let mut rig = waiting(0.0);
    rig.pass(0.3);
    let delay = rig.bench.signals.loop_delay.get().unwrap();
    assert!((delay.seconds - DELAY_S).abs() < 1e-3, "{delay:?}");
    let mut rig = waiting(0.003);
    rig.pass(0.5);
    let delay = rig.bench.signals.loop_delay.get().unwrap();
    assert!((delay.seconds - DELAY_S - 0.003).abs() < 1e-3, "{delay:?}");
}

/// Fault 16.
#[test]
fn another_delay_stops_the_drive_by_its_name() {
    let mut rig = waiting(0.02);
    let until_ns = rig.apparatus.now_ns() + 400_000_000;
    while rig.apparatus.now_ns() < until_ns {
        if let SafetyState::Tripped { trip } = rig.tick() {
            let Trip::LoopDelay { present_s, .. } = trip else {
                panic!("{trip}")
            };
            assert!((present_s - DELAY_S - 0.02).abs() < 1e-3, "{trip}");
            return;
        }
    }
    panic!("nothing stopped the drive");
}
