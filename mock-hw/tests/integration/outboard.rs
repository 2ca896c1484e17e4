//! Apparatus between the two directions of an audio server.
#![cfg(unix)]

use mock_hw::apparatus::{Outboard, Timetable};
use mock_world::scenario::Scenario;

#[test]
fn the_timetable_begins_with_the_drive_and_ends_with_it() {
    let mut outboard =
        Outboard::new(&Scenario::default(), 1, 192_000, Timetable::default()).unwrap();
    let mut inputs = vec![0.0; 1_920 * outboard.channels()];
    let mut pass = |level: f32, seconds: f64| {
        for _ in 0..(100.0 * seconds) as usize {
            outboard.process(&[level; 1_920], &mut inputs).unwrap();
        }
        outboard.is_touched()
    };
    assert!(!pass(0.0, 2.0), "no drive, no finger");
    assert!(!pass(0.1, 1.4));
    assert!(pass(0.1, 0.2));
    assert!(pass(0.0, 0.4), "a pause of the modulation");
    assert!(!pass(0.0, 0.2), "off");
    assert!(!pass(0.1, 1.0), "and from the beginning");
}
