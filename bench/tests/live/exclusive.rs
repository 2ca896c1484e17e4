//! An open sound card or serial port cannot be opened by another program (FAULTS.md, rows 5 and 34).

use config::Effective;
use devices::Bench;
use mock_world::scenario::Scenario;
use signalgen::audio::AudioError;
use sources::Lines;
use sources::serial::open_port;

use crate::rig::{Rig, apparatus, config, hardware};

/// Fault 34.
#[test]
fn a_force_sensor_that_is_listened_to_is_not_opened_again() {
    let unopened = apparatus(Scenario::default());
    open_port(unopened.force_port().unwrap(), 2_000_000).unwrap();

    let rig = Rig::new(Scenario::default(), config(&[]), None);
    let second = open_port(rig.apparatus.force_port().unwrap(), 2_000_000);
    let error = format!("{:#}", second.err().unwrap());
    assert!(
        error.contains("force sensor's port") && error.contains("free"),
        "{error}"
    );
}

/// Fault 5.
#[test]
fn a_sound_card_that_plays_for_another_is_refused_by_its_name_with_what_to_do() {
    let rig = Rig::new(Scenario::default(), config(&[]), None);
    let second_hardware = hardware(&rig.apparatus, Lines::default());
    let bench = Effective::uncalibrated(config(&[]));
    let error = Bench::open(&bench, 35_000.0, second_hardware)
        .err()
        .unwrap();
    let Some(AudioError::Busy { device, holder, .. }) = error.downcast_ref() else {
        panic!("{error:#}");
    };
    assert!(device.contains("sim"), "{device}");
    assert!(holder.contains("another program holds it"), "{holder}");
}
