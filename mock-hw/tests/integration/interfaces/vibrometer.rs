//! Serial line of the vibrometer.

use std::time::Duration;

use mock_world::scenario::Scenario;

use super::streams::{pass, read_available, stepped};

#[test]
fn a_vibrometer_sends_a_hundred_micrometre_lines_a_second() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut port = serialport::new(
        apparatus.vibrometer_port().unwrap().to_str().unwrap(),
        115_200,
    )
    .timeout(Duration::from_millis(20))
    .open()
    .unwrap();
    pass(&mut apparatus, 0.1);
    read_available(&mut *port);
    let mut text = String::new();
    for _ in 0..10 {
        pass(&mut apparatus, 0.1);
        text += &String::from_utf8(read_available(&mut *port)).unwrap();
    }
    let readings_um: Vec<f64> = text.lines().map(|line| line.parse().unwrap()).collect();
    assert!(
        (99..=101).contains(&readings_um.len()),
        "{} lines",
        readings_um.len()
    );
    let rms_um =
        (readings_um.iter().map(|um| um * um).sum::<f64>() / readings_um.len() as f64).sqrt();
    assert!(
        (3e-4..8e-4).contains(&rms_um),
        "{rms_um} µm of a plate at rest"
    );
}
