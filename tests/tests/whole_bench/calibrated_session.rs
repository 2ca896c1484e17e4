//! A participant's session on an unknown bench, with all constants from the `calibrate` commands, compared with the same
//! session under the true constants. Its estimates of the participant must be as accurate as those of the other.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::{Path, PathBuf};

use analysis::estimate::Method;
use analysis::{Settings, analyse};
use attempts::find;
use bench_tests::program::protocol;
use bench_tests::recorded::Recording;
use bench_tests::room::Room;
use bench_tests::session::{finish, text};
use bench_tests::truth::{Bench, Skin};
use config::CalibrationFile;
use recording::manifest::{RecordedProfile, WavelengthSource};
use statistics::quantile;

const UNKNOWN_BENCH: &str = "[jitter]\nenabled = true\n";
/// Greatest additional error from calibrating by the commands, as a share of the true value.
const TOLERANCE: f64 = 0.02;

/// Errors of a session's medians, as shares of the true values; friction as the RMS over its whole range.
#[derive(Debug, Clone, Copy)]
struct Errors {
    sigma_t: f64,
    z_t: f64,
    mu: f64,
}

/// Runs a session; returns the folders of its study and of its truth.
fn run(room: &Room, name: &str) -> [PathBuf; 2] {
    let folder = room.folder.path().join(name);
    let (study, truth) = (folder.join("study"), folder.join("truth"));
    std::fs::create_dir_all(&truth).unwrap();
    let mut command = room.command(&["run", "--headless", "--participant", "sub-01"]);
    command
        .args(["--consent-by", "A. Tester", "--study"])
        .arg(&study)
        .arg("--protocol")
        .arg(protocol("one-exploration.toml"))
        .arg("--mock-truth")
        .arg(&truth);
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", text(&output));
    [study, truth]
}

fn session(room: &Room, name: &str) -> [Errors; 2] {
    let [study, truth] = run(room, name);
    errors(&study, &Skin::read(&truth))
}

/// Returns the errors of the published and of the dynamic method.
fn errors(study: &Path, skin: &Skin) -> [Errors; 2] {
    let recordings = find::recordings(&[study.to_owned()], false).unwrap();
    let analysis = analyse(&recordings, &Settings::default(), |_| {});
    Method::BOTH.map(|method| {
        let median = |value: &dyn Fn(&analysis::estimate::InstanceEstimate) -> f64| {
            let mut values: Vec<f64> = analysis
                .instances()
                .filter_map(|(_, instance)| instance.estimate(method))
                .map(value)
                .collect();
            assert!(values.len() >= 5, "{} instances", values.len());
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5).unwrap()
        };
        Errors {
            sigma_t: (median(&|e| e.sigma_t_m()) / skin.sigma_t_m - 1.0).abs(),
            z_t: (num_complex::Complex64::new(
                median(&|e| e.z_t_n_s_per_m.re),
                median(&|e| e.z_t_n_s_per_m.im),
            ) - skin.z_t)
                .norm()
                / skin.z_t.norm(),
            mu: median(&|e| e.agreement.rms_mu),
        }
    })
}

/// Requires the recordings of a session to have the calibration's profile, place by place, or no profile.
fn assert_profile_recorded(room: &Room, name: &str, is_measured: bool) {
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let places = calibration.profile.map(|profile| profile.places);
    let expected = places.map(|places| RecordedProfile {
        positions_m: places.iter().map(|place| place.position_m).collect(),
        ratios: places.iter().map(|place| place.ratio).collect(),
    });
    assert_eq!(expected.is_some(), is_measured);
    let study = room.folder.path().join(name).join("study");
    let recordings = find::recordings(&[study], false).unwrap();
    assert!(!recordings.is_empty());
    for recording in recordings {
        let profile = Recording::read(&recording)
            .manifest
            .plate()
            .unwrap()
            .profile
            .clone();
        assert_eq!(profile, expected);
    }
}

/// Requires the true errors of the recorded constants to be within four of their stated standard errors, which are below a
/// hundredth.
fn assert_errors_recorded(room: &Room, name: &str, seed: u64) {
    let truth = Bench::realise(UNKNOWN_BENCH, seed);
    let study = room.folder.path().join(name).join("study");
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let force = calibration.force.unwrap().correction().matrix;
    for recording in find::recordings(&[study], false).unwrap() {
        let manifest = Recording::read(&recording).manifest;
        let signals = manifest.signals().unwrap();
        let (pickup, plate) = (&signals.channels.pickup, &signals.plate);
        let standard_errors = manifest.standard_errors.unwrap();
        let deviation = |value: f64, truth: f64| value / truth - 1.0;
        let (amplitude, factor) = (
            deviation(pickup.metres_per_unit, truth.metres_per_unit),
            deviation(plate.force_factor_n_per_v, truth.force_factor_n_per_v),
        );
        for (quantity, deviation, error) in [
            ("amplitude", amplitude, standard_errors.amplitude_relative),
            (
                "impedance",
                factor - amplitude,
                standard_errors.impedance_relative,
            ),
            (
                "phase",
                pickup.phase_rad - truth.pickup_phase_rad,
                standard_errors.pickup_phase_rad,
            ),
            (
                "normal force",
                deviation(force[0][0], truth.force[0][0]),
                standard_errors.normal_force_relative,
            ),
            (
                "lateral force",
                deviation(force[1][1], truth.force[1][1]),
                standard_errors.lateral_force_relative,
            ),
        ] {
            assert!(
                deviation.abs() < 4.0 * error && error < 0.01,
                "seed {seed}, {quantity}: off by {deviation:.1e}, stated {error:.1e}"
            );
        }
    }
}

/// Requires constants outside a recording's range to be refused before a session: a profile, and an error of a constant.
fn assert_refused_out_of_range(room: &Room) {
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    let (profile, plate) = (calibration.profile, calibration.plate);
    room.change(|calibration| calibration.profile.as_mut().unwrap().places[0].ratio = 3.0);
    assert_refused(room, "calibrate plate --along");
    room.change(|calibration| {
        calibration.profile = profile.clone();
        let phase = &mut calibration.plate.as_mut().unwrap().pickup_phase_rad;
        phase.standard_error = f64::NAN;
    });
    assert_refused(room, "standard_errors.pickup_phase_rad");
    room.change(|calibration| calibration.plate = plate.clone());
}

fn assert_refused(room: &Room, reason: &str) {
    let study = room.folder.path().join("refused");
    let mut command = room.command(&["run", "--headless", "--participant", "sub-01"]);
    command
        .args(["--consent-by", "A. Tester", "--study"])
        .arg(&study);
    let output = finish(&mut command);
    assert!(!output.status.success());
    assert!(
        text(&output).contains(reason),
        "{reason}: {}",
        text(&output)
    );
    assert!(!study.exists());
}

#[test]
fn a_session_with_measured_constants_is_as_accurate_as_with_true_ones() {
    for seed in 1..=2 {
        let room = Room::new(UNKNOWN_BENCH, seed);
        room.succeed(&["pickup"]);
        // The second bench also measures the amplitude along the plate, which is as uniform as the bench assumes.
        let plate = ["plate", "--along", "5"];
        room.succeed(&plate[..if seed == 2 { 3 } else { 1 }]);
        room.weigh();
        let command_errors = session(&room, "by-commands");
        assert_profile_recorded(&room, "by-commands", seed == 2);
        assert_errors_recorded(&room, "by-commands", seed);
        if seed == 2 {
            assert_refused_out_of_range(&room);
        }
        room.change(|calibration| {
            Bench::realise(UNKNOWN_BENCH, seed).put_into(calibration);
            calibration.profile = None;
        });
        let truth_errors = session(&room, "by-truth");
        println!("seed {seed}: by commands {command_errors:.4?}, by truth {truth_errors:.4?}");
        for (command_error, truth_error) in command_errors.iter().zip(&truth_errors) {
            assert!(
                command_error.sigma_t <= truth_error.sigma_t + TOLERANCE
                    && command_error.z_t <= truth_error.z_t + TOLERANCE
                    && command_error.mu <= truth_error.mu + TOLERANCE,
                "seed {seed}: {command_error:?} by the commands, {truth_error:?} by the truth"
            );
        }
    }
}

#[test]
fn a_session_records_the_wavelength_across_the_plate() {
    let scenario = "[plate.across]\nwavelength_m = 0.022\n[film.contact_width]\nwidth_m = 0.008\n";
    let room = Room::new(scenario, 1);
    room.succeed(&["pickup"]);
    room.succeed(&["plate", "--across", "9"]);
    room.weigh();
    let [study, _] = run(&room, "wide");
    let recordings = find::recordings(std::slice::from_ref(&study), false).unwrap();
    assert!(!recordings.is_empty());
    for recording in &recordings {
        let across = Recording::read(recording)
            .manifest
            .plate()
            .unwrap()
            .across
            .unwrap();
        assert_eq!(across.source, WavelengthSource::Measured);
        let error_m = (across.wavelength_m - 0.022).abs();
        assert!(
            error_m < 1e-4 && across.standard_error_m < 2e-4,
            "{across:?}"
        );
    }
    let analysis = analyse(&recordings, &Settings::default(), |_| {});
    let findings = analysis.findings().next().unwrap();
    assert!(findings.plate().unwrap().across.is_some() && !findings.instances.is_empty());
}

/// A computer without GPIO or sensor lines: forces, position, e-stop, enable and heartbeat are behind a field box.
const FIELD_BOX: &str = "[force_sensor]\nrate_hz = 4000.0\nburst_period_s = 0.001\ninterface = \"field-box\"\n[jitter]\nenabled = true\n";

/// Fault 41.
#[test]
fn a_calibrated_session_behind_a_field_box_finds_what_one_on_todays_lines_finds() {
    let [box_errors, line_errors] =
        [FIELD_BOX, &FIELD_BOX.replace("field-box", "serial")].map(|scenario| {
            let room = Room::new(scenario, 1);
            room.succeed(&["pickup"]);
            room.succeed(&["plate"]);
            room.weigh();
            session(&room, "session")
        });
    println!("behind a box {box_errors:.4?}, on lines {line_errors:.4?}");
    for (box_error, line_error) in box_errors.iter().zip(&line_errors) {
        assert!(
            box_error.sigma_t <= line_error.sigma_t + TOLERANCE
                && box_error.z_t <= line_error.z_t + TOLERANCE
                && box_error.mu <= line_error.mu + TOLERANCE,
            "{box_error:?} behind a box, {line_error:?} on lines"
        );
    }
}
