//! Faults rehearsed from the command line: the recording declares them, and impossible ones are refused.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::process::Command;

use bench_tests::program::{bench, protocol};
use bench_tests::session::{
    SOUND_CARD, SessionFolder, finish, headless_run, text, write_bench_config, write_demo_protocol,
};
use config::CalibrationFile;
use recording::RecordingReader;

use super::refusals::{ONE_TRIAL, assert_early_refusal, assert_refusal, room, uncalibrated};

/// Returns a drill of one fault in `folder`.
fn drill(folder: &Path, fault: &str) -> Command {
    let mut command = bench();
    command
        .current_dir(folder)
        .args(["drill", "--mock", "--headless", "--speed", "max"])
        .args(["--operator", "ME", "--only", fault]);
    command
}

#[test]
fn rehearsed_faults_are_declared_everywhere() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_TRIAL);
    let mut run = headless_run(&study, "sub-01", protocol);
    run.args(["--fault", "xrun@3s:96", "--fault", "force-dropped@3500ms"]);
    let output = finish(&mut run);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(transcript.contains("REHEARSAL, not data"), "{transcript}");
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let faults = ["xrun@3s:96", "force-dropped@3.5s"];
    assert_eq!(session.starts()[0].rehearsed, faults);
    for folder in session.recordings() {
        let reader = RecordingReader::open(&folder).unwrap();
        assert_eq!(
            reader.manifest().hardware.as_ref().unwrap().rehearsed,
            faults
        );
    }
    let output = finish(bench().arg("analyze").arg(&study).args(["--json", "-"]));
    assert!(
        text(&output).contains("a rehearsal, not data"),
        "{}",
        text(&output)
    );
}

#[test]
fn faults_are_refused_where_they_cannot_be_injected() {
    let (folder, study) = room();
    let config = write_bench_config(folder.path(), &[]);
    let mut run = uncalibrated(&study, &config);
    run.args(["--fault", "estop@3s"]);
    assert_early_refusal(&mut run, &study, &["this is real", "friction-bench drill"]);

    for (fault, words) in [
        ("estp@3s", "did you mean `estop`?"),
        ("estop", "estop@12s"),
        ("estop@3", "s or ms"),
        ("xrun@3s:0", "1 to 4800 frames"),
        ("nan@3s", "sample_format"),
    ] {
        let mut monitor = bench();
        monitor.args([
            "monitor",
            "--mock",
            "--headless",
            "--duration-s",
            "1",
            "--fault",
            fault,
        ]);
        assert_refusal(&finish(&mut monitor), &[words]);
    }
    assert_refusal(
        &finish(&mut drill(folder.path(), "relay-welded")),
        &["check --mock --fault relay-welded@0s"],
    );
    assert!(!folder.path().join("drills").exists());
}

/// Faults 16, 19.
/// Hazards 17, 18.
#[test]
fn a_fault_that_is_there_from_the_start_is_found_by_the_check_that_precedes() {
    let (_folder, study) = room();
    for (fault, row) in [
        ("relay-welded@0s", "FAILED  relay"),
        ("amplifier-off@0s", "FAILED  "),
    ] {
        let mut run = headless_run(&study, "sub-01", "demo");
        run.args(["--fault", fault]);
        assert_early_refusal(
            &mut run,
            &study,
            &[row, "nothing was driven but the test's faint tone"],
        );
    }
}

/// Fault 17.
#[test]
fn a_fault_comes_at_its_time_in_a_monitor_and_a_drill_ends_with_its_times() {
    let (folder, _) = room();
    let mut monitor = bench();
    monitor
        .args([
            "monitor",
            "--mock",
            "--headless",
            "--speed",
            "max",
            "--drive-v",
            "20",
        ])
        .args(["--duration-s", "6", "--fault", "estop@2s"]);
    let output = finish(&mut monitor);
    let transcript = text(&output);
    assert_eq!(output.status.code(), Some(1), "{transcript}");
    assert!(
        transcript.contains("STOPPED: e-stop pressed"),
        "{transcript}"
    );
    // One line for the first second, one for the second as it stops, and no later ones.
    assert_eq!(transcript.matches("Z_m").count(), 2, "{transcript}");

    let output = finish(&mut drill(folder.path(), "estop"));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    for words in ["1 of 1 met", "drill.toml", "row 17"] {
        assert!(transcript.contains(words), "{transcript}");
    }
}

/// Returns the largest amplitude of the plate within these seconds of the apparatus's time, m.
fn amplitude_m(truth: &str, interval_s: std::ops::Range<f64>) -> f64 {
    let row = |line: &str| -> (f64, f64) {
        let cell = |column: usize| line.split(',').nth(column).unwrap().parse().unwrap();
        (cell(0), cell(13))
    };
    let rows = truth.lines().skip(1).map(row);
    rows.filter(|(time_s, _)| interval_s.contains(time_s))
        .map(|(_, amplitude_m)| amplitude_m)
        .fold(0.0, f64::max)
}

/// Faults 16, 21.
/// Hazards 3, 18, 20.
#[test]
fn half_the_gain_and_a_silent_force_sensor_stop_the_program_in_time() {
    /// Time of the faults, s: the finger slides.
    const FAULT_S: f64 = 5.0;
    /// Duration of a period of the simulation and the plate's decay, s.
    const DECAY_S: f64 = 0.02;
    let (folder, _) = room();
    let config = write_bench_config(folder.path(), &[SOUND_CARD]);
    for (fault, words, limit_s) in [
        ("amplifier-gain@5s:50", "reads back", 0.25),
        // The allowed silence, plus a period of the bursts and one of the watch.
        ("force-silent@5s", "the force sensor", 0.05 + 0.02),
    ] {
        let study = folder.path().join(&fault[..5]);
        let truth = folder.path().join(format!("{}-truth", &fault[..5]));
        std::fs::create_dir(&truth).unwrap();
        let mut run = headless_run(&study, "sub-01", protocol("one-exploration.toml"));
        run.arg("--config").arg(&config).args(["--fault", fault]);
        let output = finish(run.arg("--mock-truth").arg(&truth));
        let transcript = text(&output);
        assert_eq!(output.status.code(), Some(1), "{transcript}");
        assert!(
            transcript.contains("STOPPED") && transcript.contains(words),
            "{transcript}"
        );
        let truth = std::fs::read_to_string(truth.join("truth.csv")).unwrap();
        let driven_m = amplitude_m(&truth, FAULT_S - 0.3..FAULT_S);
        assert!(driven_m > 1e-7, "{fault}: {driven_m} m before");
        let residual_m = amplitude_m(&truth, FAULT_S + limit_s + DECAY_S..f64::INFINITY);
        assert!(
            residual_m < 0.01 * driven_m,
            "{fault}: {residual_m} m of {driven_m} m"
        );
    }
}

/// Fault 36.
#[test]
fn a_calibration_with_faults_says_so_and_is_in_force_nowhere() {
    let (folder, study) = room();
    let calibration = folder.path().join("calibration.toml");
    let calibrate = |faults: &[&str]| {
        let mut calibrate = bench();
        calibrate
            .args(["calibrate", "pickup", "--mock", "--headless"])
            .args(["--speed", "max", "--operator", "ME", "--calibration"])
            .arg(&calibration)
            .args(faults);
        finish(&mut calibrate)
    };
    let output = calibrate(&["--fault", "button-held@1s"]);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(transcript.contains("REHEARSAL, not data"), "{transcript}");
    let (file, _) = CalibrationFile::read(&calibration).unwrap();
    assert_eq!(file.rehearsed, ["button-held@1s"]);
    for name in ["csv", "svg"] {
        let path = folder
            .path()
            .join(format!("calibration-rehearsal-pickup.{name}"));
        assert!(path.is_file(), "{transcript}");
    }
    // No measurement is added to it, and no session uses it.
    assert_refusal(&calibrate(&[]), &["contains a rehearsal"]);
    let mut run = headless_run(&study, "sub-01", "demo");
    run.arg("--calibration").arg(&calibration);
    assert_early_refusal(
        &mut run,
        &study,
        &["measured in a rehearsal", "button-held@1s"],
    );
    // Nor is a rehearsal added to a measured calibration.
    std::fs::remove_file(&calibration).unwrap();
    assert!(calibrate(&[]).status.success());
    let content = std::fs::read(&calibration).unwrap();
    assert_refusal(
        &calibrate(&["--fault", "button-held@1s"]),
        &["contains measurements"],
    );
    assert_eq!(std::fs::read(&calibration).unwrap(), content);
}
