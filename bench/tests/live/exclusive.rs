//! A serial port that is open is nobody else's (FAULTS.md, row 34).

use devices::force::open_port;
use mock_world::scenario::Scenario;

use crate::rig::{Rig, apparatus, config};

/// Fault 34.
#[test]
fn a_force_sensor_that_is_listened_to_is_not_opened_again() {
    let alone = apparatus(Scenario::default());
    open_port(alone.force_port().unwrap(), 2_000_000).unwrap();

    let rig = Rig::new(Scenario::default(), config(&[]), None);
    let second = open_port(rig.apparatus.force_port().unwrap(), 2_000_000);
    let error = format!("{:#}", second.err().unwrap());
    assert!(
        error.contains("force sensor's port") && error.contains("free"),
        "{error}"
    );
}
