//! Calibration by the commands, compared with the truth of simulated benches, and refused where it does not apply.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::Path;

use bench_tests::campaign;
use bench_tests::room::{Room, require_refusal};
use bench_tests::session::{finish, text};
use bench_tests::truth::{Bench, has_coverage};
use config::{CalibrationFile, Config, CosineVerdict, Effective, Quantity, Uniformity};
use rayon::prelude::*;

/// An unknown bench with a converter that has the resolution and noise of 16, 20 or 24 bits.
fn unknown_bench(seed: u64) -> String {
    let (bits, noise) = [(16, 1e-7), (20, 3e-8), (24, 5e-9)][(seed % 3) as usize];
    format!(
        "[jitter]\nenabled = true\n[converter]\nbits = {bits}\nnoise_units_per_sqrt_hz = {noise:e}\n"
    )
}

/// Error of a value, and half the width of its 95 % interval.
#[derive(Clone, Copy)]
struct Miss {
    error: f64,
    half_width: f64,
}

impl Miss {
    fn absolute(quantity: &Quantity, truth: f64) -> Self {
        Self {
            error: quantity.value - truth,
            half_width: quantity.half_width_95(),
        }
    }

    fn relative(quantity: &Quantity, truth: f64) -> Self {
        let Self { error, half_width } = Self::absolute(quantity, truth);
        Self {
            error: error / truth,
            half_width: half_width / truth,
        }
    }
}

const NAMES: [&str; 5] = ["pickup", "f0 Hz", "Q", "gamma", "phase rad"];
/// Required accuracy of each value.
const REQUIREMENTS: [f64; 5] = [3e-3, 0.5, 1e-2, 1e-2, 2e-3];

fn misses(seed: u64) -> [Miss; 5] {
    let scenario = unknown_bench(seed);
    let room = Room::new(&scenario, seed);
    room.succeed(&["pickup"]);
    room.succeed(&["plate"]);
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let (pickup, plate) = (calibration.pickup.unwrap(), calibration.plate.unwrap());
    let truth = Bench::realise(&scenario, seed);
    [
        Miss::relative(&pickup.metres_per_unit, truth.metres_per_unit),
        Miss::absolute(&plate.resonance_hz, truth.resonance_hz),
        Miss::relative(&plate.quality, truth.quality),
        Miss::relative(&plate.force_factor_n_per_v, truth.force_factor_n_per_v),
        Miss::absolute(&plate.pickup_phase_rad, truth.pickup_phase_rad),
    ]
}

#[test]
fn unknown_benches_are_known_within_their_intervals() {
    let benches = campaign::repeats("FRICTION_BENCH_BENCHES", 5);
    let seeds = (1..=benches as u64).into_par_iter();
    let bench_misses: Vec<_> = seeds.map(misses).collect();
    let mut lines = Vec::new();
    for (i, (name, requirement)) in NAMES.iter().zip(REQUIREMENTS).enumerate() {
        let mut errors: Vec<f64> = bench_misses
            .iter()
            .map(|seed| seed[i].error.abs())
            .collect();
        errors.sort_by(f64::total_cmp);
        let hits = bench_misses
            .iter()
            .filter(|seed| seed[i].error.abs() <= seed[i].half_width)
            .count();
        let median_width = {
            let mut widths: Vec<f64> = bench_misses.iter().map(|seed| seed[i].half_width).collect();
            widths.sort_by(f64::total_cmp);
            widths[widths.len() / 2]
        };
        let worst = errors[errors.len() - 1];
        lines.push(format!(
            "{name} median {:.1e}, worst {worst:.1e}, demanded {requirement:.1e}, 95 % interval ± {median_width:.1e}, holds the truth {hits}",
            errors[errors.len() / 2]
        ));
        assert!(
            worst <= requirement,
            "{name}: {worst:e} over {requirement:e}"
        );
        assert!(has_coverage(hits, benches), "{name}: {hits} of {benches}");
    }
    campaign::report("unknown benches calibrated", benches, &lines.join("; "));
}

#[test]
fn a_plate_under_a_finger_is_kept_beside_the_bare_one_and_changes_no_constant() {
    let room = Room::new("", 1);
    room.succeed(&["pickup"]);
    let transcript = room.succeed(&["plate", "--finger"]);
    assert!(transcript.contains("under a finger"), "{transcript}");
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let (finger, plate) = (
        calibration.finger.clone().unwrap(),
        calibration.plate.clone().unwrap(),
    );
    assert!(
        (0.3..=1.0).contains(&finger.normal_n.value),
        "{}",
        finger.normal_n
    );
    assert!(finger.normal_spread_n > 0.0 && finger.drive_v <= 6.0);
    // The finger adds damping, and only its own impedance in full contact, far below the plate's.
    assert!(finger.quality.unwrap().value < plate.quality.value);
    let table = room
        .calibration()
        .with_file_name("calibration-plate-finger.csv");
    let table = fs::read_to_string(table).unwrap();
    let impedances: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(5).unwrap().parse().unwrap())
        .collect();
    assert_eq!(impedances.len(), 31);
    let mean = impedances.iter().sum::<f64>() / impedances.len() as f64;
    assert!((0.3..10.0).contains(&mean), "{mean} N·s/m");

    let calibration_without_finger = CalibrationFile {
        finger: None,
        ..calibration.clone()
    };
    let config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
    let effective = |file: &CalibrationFile| Effective::under_calibration(config.clone(), file);
    assert_ne!(effective(&calibration).config(), &config);
    assert_eq!(
        effective(&calibration),
        effective(&calibration_without_finger)
    );
    assert_eq!(
        calibration.oldest(true),
        calibration_without_finger.oldest(true)
    );

    // A new measurement of the plate discards the response of the previous one.
    let transcript = room.succeed(&["plate"]);
    assert!(transcript.contains("was taken out"), "{transcript}");
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    assert_eq!(calibration.finger, None);
}

#[test]
fn the_amplitude_along_the_plate_is_found_and_judged() {
    for (end_drop, verdict) in [(0.0, Uniformity::Uniform), (0.08, Uniformity::NotUniform)] {
        let room = Room::new(&format!("[plate]\nend_drop = {end_drop:?}\n"), 1);
        require_refusal(
            room.calibrate(&["plate", "--along", "5"]),
            &["calibrate pickup"],
        );
        room.succeed(&["pickup"]);
        room.succeed(&["plate", "--along", "5"]);
        let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
        let profile = calibration.profile.unwrap();
        assert_eq!(profile.verdict, verdict, "{profile:?}");
        for place in &profile.places {
            let x = 2.0 * place.position_m / 0.105 - 1.0;
            let truth = 1.0 - end_drop * x * x;
            // The vibrometer's scale error is common to all places and to the pickup.
            let error = (place.ratio - truth).abs();
            assert!(error < 5e-3, "{place:?}, truth {truth}");
        }
        // A new sensitivity of the pickup changes the ratio.
        room.succeed(&["pickup"]);
        let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
        assert_eq!(calibration.profile, None);
    }
}

#[test]
fn the_wavelength_across_the_plate_is_found_and_stored() {
    const WIDE: &str = "[plate.across]\nwavelength_m = 0.0245\ncrest_m = 0.3e-3\n";
    let room = Room::new(WIDE, 1);
    require_refusal(
        room.calibrate(&["plate", "--across", "9"]),
        &["calibrate pickup"],
    );
    room.succeed(&["pickup"]);
    require_refusal(
        room.calibrate(&["plate", "--across", "2"]),
        &["--across = 2 is outside 6 to 50"],
    );
    let transcript = room.succeed(&["plate", "--across", "9"]);
    assert!(
        transcript.contains("a cosine of wavelength 24.5"),
        "{transcript}"
    );
    let folder = room.folder.path();
    assert!(folder.join("calibration-plate-across.svg").exists());
    assert!(folder.join("calibration-plate-across.csv").exists());
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let across = calibration.across.unwrap();
    assert_eq!(across.verdict, CosineVerdict::Cosine);
    for (quantity, truth, most) in [
        (across.wavelength_m, 0.0245, 1e-4),
        (across.crest_m, 0.3e-3, 5e-5),
        (across.crest_ratio, 1.0, 5e-3),
    ] {
        let quantity = quantity.unwrap();
        assert!((quantity.value - truth).abs() < most, "{quantity:?}");
        assert!(quantity.standard_error < most, "{quantity:?}");
    }

    // A new sensitivity of the pickup changes the ratios.
    room.succeed(&["pickup"]);
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    assert_eq!(calibration.across, None);
}

#[test]
fn a_plate_that_moves_alike_across_has_no_wavelength_there() {
    let room = Room::new("", 1);
    room.succeed(&["pickup"]);
    let transcript = room.succeed(&["plate", "--across", "6"]);
    assert!(transcript.contains("no wavelength"), "{transcript}");
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let across = calibration.across.unwrap();
    assert_eq!(across.verdict, CosineVerdict::Undetermined);
    assert_eq!(across.wavelength_m, None);
    assert_eq!(across.places.len(), 6);
}

/// Admittance of the actuators of a bench, S: 10 nF beside the current of the moving plate.
fn admittance(truth: &Bench, modal_mass_kg: f64, frequency_hz: f64) -> [f64; 2] {
    let omega = std::f64::consts::TAU * frequency_hz;
    let omega0 = std::f64::consts::TAU * truth.resonance_hz;
    let resistance = omega0 * modal_mass_kg / truth.quality;
    let reactance = omega * modal_mass_kg - omega0 * omega0 * modal_mass_kg / omega;
    let per_force = truth.force_factor_n_per_v.powi(2) / resistance.hypot(reactance).powi(2);
    [
        per_force * resistance,
        omega * 10e-9 - per_force * reactance,
    ]
}

#[test]
fn a_sweep_from_elsewhere_gives_the_constants_of_the_bench() {
    let room = Room::new(&unknown_bench(3), 3);
    let truth = Bench::realise(&unknown_bench(3), 3);
    let modal_mass_kg = Config::parse(config::rigs::MOCK_BENCH, "test")
        .unwrap()
        .plate
        .modal_mass_kg;
    let mut table = "f / kHz;G / mS;B / mS\n".to_owned();
    for n in 0..160 {
        let frequency_hz = truth.resonance_hz + 10.0 * (f64::from(n) - 75.0);
        let [g, b] = admittance(&truth, modal_mass_kg, frequency_hz);
        let row = format!("{};{};{}\n", frequency_hz / 1e3, g * 1e3, b * 1e3);
        table.push_str(&row.replace('.', ","));
    }
    let sweep = room.folder.path().join("sweep.csv");
    fs::write(&sweep, table).unwrap();
    room.succeed(&["plate", "--from", sweep.to_str().unwrap()]);
    assert!(room.folder.path().join("calibration-plate.svg").exists());
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let plate = calibration.plate.unwrap();
    for (quantity, truth) in [
        (&plate.resonance_hz, truth.resonance_hz),
        (&plate.quality, truth.quality),
        (&plate.force_factor_n_per_v, truth.force_factor_n_per_v),
    ] {
        let miss = Miss::relative(quantity, truth);
        assert!(miss.error.abs() < 1e-3, "{quantity}, truly {truth}");
    }
    let origin = plate.sweep.unwrap();
    assert_eq!(
        (origin.file.as_str(), origin.quantity.as_str()),
        ("sweep.csv", "admittance")
    );
    let missing = room.calibrate(&["plate", "--from", "nowhere.csv"]);
    require_refusal(missing, &["nowhere.csv"]);
}

#[test]
fn a_plate_is_measured_in_under_twenty_seconds_of_signal() {
    let room = Room::new("", 1);
    room.succeed(&["pickup"]);
    let transcript = room.succeed(&["plate"]);
    let driven_s: f64 = transcript
        .lines()
        .find_map(|line| line.trim().strip_prefix("driven for"))
        .and_then(|rest| rest.trim().strip_suffix(" s"))
        .unwrap()
        .parse()
        .unwrap();
    assert!(driven_s > 1.0 && driven_s < 20.0, "{driven_s}");
    let bode = fs::read_to_string(room.folder.path().join("calibration-plate.csv")).unwrap();
    let peak = bode
        .lines()
        .skip(1)
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            values[1].hypot(values[2])
        })
        .fold(0.0, f64::max);
    // 1/b_p at the resonance; one of the 31 tones lies within 3 % of it.
    assert!((peak * 7.01 - 1.0).abs() < 0.03, "{peak}");
}

#[test]
fn drift_is_reported_and_excessive_drift_refused() {
    let room = Room::calibrated();
    fs::write(&room.scenario, "[plate]\nresonance_hz = 35012.0\n").unwrap();
    let transcript = room.succeed(&["plate"]);
    let drift = transcript
        .lines()
        .find(|line| line.contains("drift"))
        .unwrap();
    assert!(
        drift.contains("+12.0") || drift.contains("+11.9"),
        "{drift}"
    );
    fs::write(&room.scenario, "[plate]\nresonance_hz = 35212.0\n").unwrap();
    require_refusal(
        room.calibrate(&["plate"]),
        &["has moved by +200", "calibration.drift_hz"],
    );
}

/// Fault 36.
/// Hazard 19.
#[test]
fn the_wrong_ones_are_refused_each_by_its_name() {
    let room = Room::new("", 1);
    require_refusal(
        room.watch(),
        &["there is no calibration", "calibrate NAME", "pickup"],
    );
    room.succeed(&["pickup"]);
    require_refusal(room.watch(), &["is not complete", "calibrate plate"]);
    room.succeed(&["plate"]);
    require_refusal(room.watch(), &["is not complete", "calibrate force"]);
    room.weigh();
    let output = finish(&mut room.watch());
    assert!(output.status.success(), "{}", text(&output));
    let file = fs::read(room.calibration()).unwrap();
    let require_refusal_after = |change: fn(&mut CalibrationFile), words: &[&str]| {
        fs::write(room.calibration(), &file).unwrap();
        room.change(change);
        require_refusal(room.watch(), words);
    };
    require_refusal_after(
        |c| c.identity.input_device = "hw:CARD=Other".to_owned(),
        &["the input device", "hw:CARD=Other", "--uncalibrated"],
    );
    require_refusal_after(
        |c| (c.identity.drive_channel, c.identity.pickup_channel) = (1, 0),
        &[
            "the channels",
            "drive on input 1, pickup on input 0",
            "bench.toml",
        ],
    );
    require_refusal_after(|c| c.identity.rate_hz = 48_000, &["a rate in Hz of 48000"]);
    require_refusal_after(
        |c| c.identity.force_sensor = Some("/dev/ttyACM3, lines".to_owned()),
        &["the force sensor", "/dev/ttyACM3, lines", "calibrate force"],
    );
    require_refusal_after(
        |c| c.force.as_mut().unwrap().normal_per_normal.value = 0.2,
        &["force.matrix", "calibrate force"],
    );
    require_refusal_after(
        |c| c.identity.plate_id = "glass 2".to_owned(),
        &["the plate \"glass 2\"", "another resonance"],
    );
    require_refusal_after(
        |c| {
            let year = jiff::SignedDuration::from_hours(365 * 24);
            let date = &mut c.plate.as_mut().unwrap().measured.date;
            *date = date.checked_sub(year).unwrap();
        },
        &["365 days old", "calibration.max_age_days"],
    );
    // The session's time is simulated, so the date of a part measured in real time is irrelevant.
    room.change(|c| c.set_simulated_time("plate", false));
    let output = finish(&mut room.watch());
    assert!(output.status.success(), "{}", text(&output));
    fs::write(room.calibration(), &file).unwrap();
    let edited_text = String::from_utf8(file)
        .unwrap()
        .replacen("0.000", "0.001", 1);
    fs::write(room.calibration(), edited_text).unwrap();
    require_refusal(room.watch(), &["was edited after it was measured"]);
}

#[test]
fn impossible_measurements_are_refused_with_the_cause() {
    let pickup: &[&str] = &["pickup"];
    let require_refusal_of = |scenario: &str, words: &[&str]| {
        require_refusal(Room::new(scenario, 1).calibrate(pickup), words);
    };
    require_refusal_of(
        "[force_sensor]\nnormal_offset_n = 0.4\n",
        &["something rests on the plate", "0.4"],
    );
    require_refusal_of(
        "[pickup]\nmetres_per_unit = 5.0e-8\n",
        &["the pickup's input is saturated"],
    );
    require_refusal_of(
        "[converter]\nreadback_volts_per_unit = 10000.0\n",
        &["the carrier does not come back", "48 kHz"],
    );
    require_refusal_of(
        "[plate]\nresonance_hz = 38000.0\n",
        &["no resonance between 34200 and 35800 Hz"],
    );
    let room = Room::new("", 1);
    require_refusal(
        room.calibrate(&["pickup", "--levels-v", "5,10", "--known-um", "0.4,8"]),
        &["--known-at-hz"],
    );
    let frequency = ["--known-at-hz", "35000"];
    let calibrate_with = |words: &[&str]| room.calibrate(&[words, &frequency[..]].concat());
    require_refusal(
        calibrate_with(&["pickup", "--levels-v", "5,10", "--known-um", "0.4,8"]),
        &["8.000 µm", "calibration.max_amplitude_m"],
    );
    require_refusal(
        calibrate_with(&["pickup", "--levels-v", "5,10", "--known-um", "0.4"]),
        &["2 levels", "1 known amplitudes"],
    );
    assert!(
        !Path::new(&room.calibration()).exists(),
        "nothing was measured"
    );
}

/// Fault 11.
#[test]
fn check_compares_the_channels_with_the_calibration() {
    let room = Room::calibrated();
    let output = finish(&mut room.check());
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(
        transcript.contains("gain and phase as calibrated"),
        "{transcript}"
    );
    for (scenario, words) in [
        (
            "[converter]\nskew_samples = [0.0, 1.0]\n",
            "slipped by -1 samples",
        ),
        (
            "[pickup]\nmetres_per_unit = 1.0e-5\n",
            "0.50 times what was calibrated",
        ),
        (
            "[plate]\nresonance_hz = 34940.0\n",
            "a finger rests on it, or it has drifted",
        ),
    ] {
        fs::write(&room.scenario, scenario).unwrap();
        require_refusal(room.check(), &["FAILED  channels", words]);
    }
    room.change(|c| c.identity.gains = "preamplifier 20 dB".to_owned());
    fs::write(&room.scenario, "").unwrap();
    require_refusal(room.check(), &["FAILED  calibration", "preamplifier 20 dB"]);
}

#[test]
fn typed_and_tabulated_amplitudes_give_the_sensitivity() {
    // γ U/(ω b_p) of the nominal plate at 5 to 40 V, behind the amplifier's roll-off at 200 kHz, rounded to nanometres as a
    // person would.
    let amplifier = (1.0 + (35.0f64 / 200.0).powi(2)).sqrt().recip();
    let levels = [5.0, 10.0, 20.0, 40.0];
    let known: Vec<String> = levels
        .iter()
        .map(|volts| {
            format!(
                "{:.3}",
                amplifier * 0.13 * volts / (std::f64::consts::TAU * 35e3 * 7.01) * 1e6
            )
        })
        .collect();
    let room = Room::new("", 1);
    room.succeed(&[
        "pickup",
        "--levels-v",
        "5,10,20,40",
        "--known-um",
        &known.join(","),
        "--known-at-hz",
        "35000",
    ]);
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let typed_m_per_unit = calibration.pickup.unwrap().metres_per_unit.value;
    assert!(
        (typed_m_per_unit / 5e-6 - 1.0).abs() < 3e-3,
        "{typed_m_per_unit}"
    );
    let table = room.folder.path().join("known.csv");
    let rows: String = levels
        .iter()
        .zip(&known)
        .map(|(volts, um)| format!("{volts},{um}\n"))
        .collect();
    fs::write(&table, format!("drive_v,known_um\n{rows}")).unwrap();
    let path = table.to_str().unwrap();
    room.succeed(&["pickup", "--known-csv", path, "--known-at-hz", "35000"]);
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let tabled_m_per_unit = calibration.pickup.unwrap().metres_per_unit.value;
    assert!(
        (tabled_m_per_unit / typed_m_per_unit - 1.0).abs() < 1e-6,
        "{tabled_m_per_unit} {typed_m_per_unit}"
    );

    // At 43 Hz off the resonance, half a half-bandwidth, the plate moves 16 % less; 6 Hz is within a tenth.
    let calibrate_at = |hz: f64| {
        let rows: String = levels
            .iter()
            .zip(&known)
            .map(|(volts, um)| format!("{volts},{um},{hz}\n"))
            .collect();
        fs::write(&table, format!("drive_v,known_um,known_at_hz\n{rows}")).unwrap();
        room.calibrate(&["pickup", "--known-csv", path])
    };
    for hz in [34_957.0, 35_043.0, 35_008.0] {
        let frequency = format!("known at {hz:.1} Hz (--known-at-hz)");
        require_refusal(
            calibrate_at(hz),
            &[&frequency, "resonance is at 3", "--reference-channel"],
        );
    }
    assert!(finish(&mut calibrate_at(35_006.0)).status.success());
}

/// Hazard 3.
#[test]
fn volts_are_checked_against_a_meter_and_a_constant_that_is_wrong_twice_is_found() {
    let meter_words = ["output", "--meter", "simulated, no. 7", "--reads", "rms"];
    let room = Room::new("", 1);
    room.succeed(&meter_words);
    let output_check = || {
        CalibrationFile::read(&room.calibration())
            .unwrap()
            .0
            .output
            .unwrap()
    };
    let carrier_check = output_check();
    assert_eq!(carrier_check.meter, "simulated, no. 7");
    // The amplifier's roll-off at 200 kHz takes 1.5 % at the carrier, and the meter has an error too.
    assert!(
        (carrier_check.per_commanded.value - 0.985).abs() < 0.01,
        "{carrier_check:?}"
    );
    assert!(
        (carrier_check.per_read_back.value - 1.0).abs() < 0.01,
        "{carrier_check:?}"
    );
    room.succeed(&[&meter_words[..], &["--meter-up-to-hz", "1000"]].concat());
    let low_check = output_check();
    assert_eq!(low_check.tone_hz, 1e3);
    assert!(
        (low_check.per_commanded.value - 0.985).abs() < 0.01,
        "{low_check:?}"
    );

    let file = fs::read(room.calibration()).unwrap();
    require_refusal(
        room.calibrate(&["output", "--meter", "m", "--reads", "peak"]),
        &["RMS where peak was asked"],
    );
    fs::write(
        &room.scenario,
        "[amplifier]\nvolts_per_unit = 65.0\n[converter]\nreadback_volts_per_unit = 65.0\n",
    )
    .unwrap();
    require_refusal(
        room.calibrate(&meter_words),
        &[
            "wrong together",
            "limits.drive_v = 55 V",
            "channels.drive.volts_per_unit = 6",
        ],
    );
    assert_eq!(
        fs::read(room.calibration()).unwrap(),
        file,
        "nothing is put in force"
    );
}
