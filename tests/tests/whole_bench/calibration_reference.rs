//! The pickup calibrated against a vibrometer with its analog output on a spare input: sensitivity and phase.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;

use bench_tests::room::{Room, require_refusal};
use bench_tests::session::{finish, text};
use bench_tests::truth::Bench;
use config::{CalibrationFile, Config, Effective};

/// A pickup that lags by 8 degrees, on a card that samples its inputs one after the other, and a vibrometer on input 3.
fn bench(quantity: &str, per_volt: f64) -> String {
    format!(
        "[pickup]\nphase_rad = 0.139626\n[converter]\nskew_samples = [0.0, 0.25, 0.5, 0.75]\n\
         [reference]\nfollows = \"{quantity}\"\nper_volt = {per_volt:e}\nvolts_per_unit = 4.0\ndelay_s = 6.3e-6\n"
    )
}

const DISPLACEMENT: [&str; 11] = [
    "pickup",
    "--reference-channel",
    "3",
    "--reference-um-per-v",
    "2",
    "--reference-volts-per-unit",
    "4",
    "--reference-delay-us",
    "6.3",
    "--reference-delay-error-us",
    "0.01",
];

fn velocity() -> Vec<&'static str> {
    let mut words = DISPLACEMENT.to_vec();
    words[3..5].copy_from_slice(&["--reference-m-per-s-per-v", "0.5"]);
    words
}

#[test]
fn a_vibrometer_on_an_input_gives_the_sensitivity_and_the_phase_and_z_m_comes_out_right() {
    let scenario = bench("displacement", 2e-6);
    let room = Room::new(&scenario, 1);
    let truth = Bench::realise(&scenario, 1);
    room.weigh();

    // The inputs have not been compared yet: the amplitude is known, the phase is not.
    let transcript = room.succeed(&DISPLACEMENT);
    assert!(
        transcript.contains("not kept: the delay between the instrument"),
        "{transcript}"
    );
    let calibration_file = || CalibrationFile::read(&room.calibration()).unwrap().0;
    assert_eq!(calibration_file().pickup.unwrap().phase_rad, None);

    room.succeed(&["channels"]);
    for (quantity, per_volt, words) in [
        ("velocity", 0.5, velocity()),
        ("displacement", 2e-6, DISPLACEMENT.to_vec()),
    ] {
        fs::write(&room.scenario, bench(quantity, per_volt)).unwrap();
        room.succeed(&words);
        let pickup = calibration_file().pickup.unwrap();
        let (sensitivity, phase) = (&pickup.metres_per_unit, pickup.phase_rad.unwrap());
        let error = sensitivity.value / truth.metres_per_unit - 1.0;
        let error_rad = phase.value - truth.pickup_phase_rad;
        println!(
            "{quantity}: sensitivity off by {error:.1e}, phase {phase} off by {error_rad:.1e} rad"
        );
        assert!(
            error.abs() < 3e-3 && error.abs() * sensitivity.value < sensitivity.half_width_95()
        );
        assert!(error_rad.abs() < 5e-3 && error_rad.abs() < phase.half_width_95());
        // Until the plate is calibrated the bench uses this phase.
        let config = config::rigs::MOCK_BENCH;
        let config = Config::parse(config, "bench.toml").unwrap();
        let effective = Effective::under_calibration(config, &calibration_file());
        assert_eq!(effective.config().channels.pickup.phase_rad, phase.value);
    }

    // The plate gives the same phase, since its force is in phase with the voltage that is read back.
    room.succeed(&["plate"]);
    let calibration = calibration_file();
    let (pickup, plate) = (calibration.pickup.unwrap(), calibration.plate.unwrap());
    let force = plate.force_phase_rad.unwrap();
    println!("force phase {force}");
    assert!(force.value.abs() < force.half_width_95(), "{force}");

    // Z_m of the free plate at its resonance is b_p, with the plate's phase and with the vibrometer's.
    let pickup_phase = pickup.phase_rad.unwrap().value;
    for phase in [plate.pickup_phase_rad.value, pickup_phase] {
        room.change(|file| file.plate.as_mut().unwrap().pickup_phase_rad.value = phase);
        let z_m = monitor_z_m(&room);
        println!("Z_m {z_m:?} with a phase of {phase:.5} rad");
        assert!((z_m.0 - 7.01).abs() < 0.05 && z_m.1.abs() < 0.05, "{z_m:?}");
    }
    // The same without the 8 degrees.
    room.change(|file| {
        file.plate.as_mut().unwrap().pickup_phase_rad.value = pickup_phase - 0.139_626
    });
    let z_m = monitor_z_m(&room);
    assert!((z_m.1.abs() - 0.98).abs() < 0.1, "{z_m:?}");
}

/// Returns Z_m as `monitor` prints it, N·s/m, real and imaginary part.
fn monitor_z_m(room: &Room) -> (f64, f64) {
    let words = [
        "monitor",
        "--headless",
        "--drive-v",
        "10",
        "--duration-s",
        "3",
    ];
    let output = finish(&mut room.command(&words));
    let transcript = text(&output);
    let line = transcript.lines().rfind(|line| line.contains("Z_m "));
    let line = line.unwrap_or_else(|| panic!("no Z_m in {transcript}"));
    let words: Vec<&str> = line.split("Z_m ").nth(1).unwrap().split(' ').collect();
    let number = |word: &str| word.trim_end_matches('i').parse().unwrap();
    (number(words[0]), number(words[1]))
}

/// Fault 11.
#[test]
fn what_the_vibrometer_cannot_have_read_is_refused() {
    let room = Room::new("", 1);
    let words_with = |option: &str, value: &'static str| -> Vec<&'static str> {
        let index = DISPLACEMENT
            .iter()
            .position(|word| *word == option)
            .unwrap();
        let mut words = DISPLACEMENT.to_vec();
        words[index + 1] = value;
        words
    };
    // That input has no signal.
    require_refusal(
        room.calibrate(&DISPLACEMENT),
        &["input 3 (--reference-channel) reads no tone"],
    );
    fs::write(&room.scenario, bench("displacement", 2e-6)).unwrap();
    for (words, message) in [
        (
            words_with("--reference-channel", "1"),
            "channels.pickup.index",
        ),
        (
            words_with("--reference-channel", "9"),
            "audio.input_channels = 4",
        ),
        (
            words_with("--reference-volts-per-unit", "0"),
            "--reference-volts-per-unit",
        ),
        (
            words_with("--reference-um-per-v", "-2"),
            "--reference-um-per-v",
        ),
        (
            words_with("--reference-delay-us", "-1"),
            "--reference-delay-us",
        ),
        (
            words_with("--reference-um-per-v", "900"),
            "calibration.max_amplitude_m",
        ),
        (
            [&DISPLACEMENT[..3], &["--reference-um-per-v", "2"]].concat(),
            "--reference-volts-per-unit",
        ),
        (
            [&DISPLACEMENT[..3], &["--reference-volts-per-unit", "2"]].concat(),
            "--reference-m-per-s-per-v",
        ),
        (
            [&DISPLACEMENT[..], &["--known-at-hz", "35000"]].concat(),
            "cannot be used with",
        ),
    ] {
        require_refusal(room.calibrate(&words), &[message]);
    }
    fs::write(
        &room.scenario,
        bench("displacement", 1e-7).replace("4.0", "1.0"),
    )
    .unwrap();
    require_refusal(room.calibrate(&DISPLACEMENT), &["is cut off", "range"]);
    assert!(!room.calibration().exists(), "nothing was measured");
}

/// Fault 6.
#[test]
fn an_xrun_that_breaks_off_a_tone_ends_a_calibration() {
    let room = Room::new("", 1);
    require_refusal(
        room.calibrate(&["pickup", "--fault", "xrun@2s:192"]),
        &["broke off a tone", "audio.buffer_frames"],
    );
}
