//! Sensors with unexpected clocks: clocks that restart, and clocks too far off to be followed.

use mock_hw::serial::ForceFault;
use mock_world::scenario::{Scenario, built_in};
use recording::manifest::EventKind;
use safety::Trip;

use crate::rig::{Rig, config, events};

/// Re-arms a tripped bench.
fn rearm(rig: &mut Rig) {
    rig.bench.drive.rearm();
    for _ in 0..100 {
        rig.tick();
    }
}

/// Returns a driven plate, with `changes` to its description.
fn driven(scenario: Scenario, changes: &[(&str, &str)]) -> Rig {
    let mut rig = Rig::new(scenario, config(changes), None);
    rig.drive();
    rig
}

/// Fault 48.
#[test]
fn a_sensor_that_restarts_stops_the_drive_by_name_and_is_read_on_after_it() {
    for (scenario, changes) in [
        (Scenario::default(), vec![]),
        (
            built_in("arduino").unwrap(),
            vec![("protocol = \"frames\"", "protocol = \"lines\"")],
        ),
    ] {
        let mut rig = driven(scenario, &changes);
        let folder = rig.begin("restart");
        rig.pass(6.0);
        rig.apparatus.faults().force(ForceFault::Restart);
        let is_expected = |trip: &Trip| {
            trip.to_string()
                .starts_with("the force sensor restarted, or its clock jumped")
        };
        rig.stops("restart", is_expected, 0.1, 0.1);
        rearm(&mut rig);
        rig.record.force.clear();
        rig.pass(1.0);
        let rows = &rig.record.force;
        assert!(rows.len() > 900, "{} rows", rows.len());
        let steps_s = rows.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let longest_s = steps_s.fold(0.0, f64::max);
        assert!(longest_s < 3e-3, "{longest_s} s");
        let audio_s = rig.account.frames as f64 / 192e3;
        let late_s = audio_s - rows[rows.len() - 1].time_s;
        assert!((0.0..0.03).contains(&late_s), "{late_s} s");
        rig.end();
        let flags = events(&folder);
        let restarts = flags.iter().filter(|event| {
            event.0 == EventKind::SensorClock && event.3.contains("force sensor restarts: 1")
        });
        assert_eq!(restarts.count(), 1, "{flags:?}");
    }
}

/// Fault 24.
#[test]
fn a_sensor_whose_rate_is_not_the_stated_one_stops_the_drive_with_what_to_do() {
    // 7000 samples a second, assumed to be 7200.
    let netft = "source = \"netft\"\nnetft = { counts_per_n = 1e6, sample_hz = 7200.0 }";
    let changes = [("port = \"/dev/ttyUSB0\"", netft)];
    let mut rig = driven(built_in("net-ft").unwrap(), &changes);
    let is_expected = |trip: &Trip| {
        let trip = trip.to_string();
        trip.contains("counts 7000 samples a second")
            && trip.contains("force.netft.sample_hz = 7200")
    };
    rig.stops("7200 Hz", is_expected, 40.0, 0.1);
}
