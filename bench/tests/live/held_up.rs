//! A loaded computer suspends the program between reading the clock and reading the data that have arrived (FAULTS.md,
//! row 24).

use mock_world::scenario::Scenario;
use recording::ForceRow;

use crate::rig::{Rig, config};

/// Returns the forces of the first eight seconds, with all tasks held up for 5 ms at every `held_up_every`th tick.
fn forces(held_up_every: u64) -> Vec<ForceRow> {
    let mut rig = Rig::new(Scenario::default(), config(&[]), None);
    rig.pass(0.1);
    rig.hold_up(held_up_every, 5_000_000);
    rig.pass(8.0);
    rig.record.force
}

/// Fault 24.
#[test]
fn forces_keep_their_place_on_the_audio_clock() {
    let (prompt, delayed) = (forces(u64::MAX), forces(7));
    assert!(prompt.len() > 70_000, "{}", prompt.len());
    assert_eq!(prompt.len(), delayed.len());
    for (prompt, delayed) in prompt.iter().zip(&delayed) {
        assert_eq!(prompt.normal_n, delayed.normal_n);
        let error_s = delayed.time_s - prompt.time_s;
        assert!(
            error_s.abs() < 1e-4,
            "{error_s} s off at {} s",
            prompt.time_s
        );
    }
}
