//! Known masses, as read from the force sensor's serial line.

use mock_world::plant::LoadedAxis;
use mock_world::scenario::Scenario;

use super::force_line::frames;
use super::streams::{open_force_port, pass, read_available, stepped};

#[test]
fn a_mass_is_read_with_gain_crosstalk_and_offset_and_goes_again() {
    let mut scenario = Scenario::default();
    let sensor = &mut scenario.force_sensor;
    sensor.noise_n = 0.0;
    (sensor.normal_gain, sensor.lateral_gain) = (1.25, 0.8);
    (sensor.lateral_to_normal, sensor.normal_to_lateral) = (0.02, -0.04);
    (sensor.normal_offset_n, sensor.lateral_offset_n) = (0.1, -0.2);
    scenario.masses.error = 0.0;
    let mut apparatus = stepped(scenario, 1);
    let masses = apparatus.masses();
    let mut port = open_force_port(&apparatus);
    let mut settled_forces_n = || {
        for _ in 0..300 {
            pass(&mut apparatus, 0.01);
            read_available(&mut *port);
        }
        pass(&mut apparatus, 0.01);
        let (received, bad) = frames(&read_available(&mut *port));
        assert_eq!(bad, 0);
        received[received.len() - 1].forces_n()
    };
    let close = |read: [f64; 2], expected: [f64; 2]| {
        let distance_n = (read[0] - expected[0]).hypot(read[1] - expected[1]);
        assert!(distance_n < 5e-6, "{read:?} {expected:?}");
    };
    close(settled_forces_n(), [0.1, -0.2]);
    masses.place(LoadedAxis::Normal, 0.1);
    let weight_n = 0.1 * 9.806_65;
    close(
        settled_forces_n(),
        [0.1 + 1.25 * weight_n, -0.2 - 0.8 * 0.04 * weight_n],
    );
    masses.remove();
    close(settled_forces_n(), [0.1, -0.2]);
    masses.place(LoadedAxis::Lateral, 0.1);
    close(
        settled_forces_n(),
        [0.1 + 1.25 * 0.02 * weight_n, -0.2 + 0.8 * weight_n],
    );
}
