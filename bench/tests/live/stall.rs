//! A disk that stalls for seconds stops neither the audio nor the recording (FAULTS.md, row 27).

use crate::rig::{CHANNELS, Level, RATE_HZ, Rig, config, samples};
use mock_world::scenario::Scenario;

/// Fault 27.
/// Hazard 14.
#[test]
fn ten_seconds_of_a_stalled_disk_cost_nothing() {
    // Long buffers: few blocks of audio, and the usual number of forces and positions.
    let config = config(&[("ring_s =", "buffer_frames = 1024\nring_s =")]);
    // A still encoder, which sends positions all the same.
    let mut rig = Rig::new(
        Scenario::default(),
        config,
        Some([Box::new(Level::default()), Box::new(Level::default())]),
    );
    rig.pass(0.3);
    let folder = rig.begin("stalled");
    rig.pass(0.2);
    rig.stall_disk(true);
    rig.pass(9.5);
    rig.stall_disk(false);
    rig.pass(0.2);
    rig.end();
    let recorded_s = samples(&folder).len() as f64 / f64::from(CHANNELS) / f64::from(RATE_HZ);
    assert!(
        (9.85..9.95).contains(&recorded_s),
        "{recorded_s} s recorded"
    );
    assert!(samples(&folder).iter().all(|x| x.is_finite()));
}
