//! The hardware stops are tested before any drive: a bench that they do not stop is not driven.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::{Path, PathBuf};

use bench_tests::program::bench;
use bench_tests::session::{
    SOUND_CARD, SessionFolder, finish, headless_run, text, write_bench_config, write_demo_protocol,
};
use devices::estop_press::{EstopPress, record_path};

use super::refusals::{ONE_TRIAL, assert_early_refusal, assert_refusal, room, uncalibrated};

fn scenario(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("scenario.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// Benches with a defective stop, and the row that reports it.
const DEFECTS: [(&str, &str); 2] = [
    (
        "[amplifier]\none_shot_s = 5.0\n",
        "FAILED  stop: heartbeat  the amplifier stays on",
    ),
    (
        "[amplifier]\none_shot_s = 0.25\n",
        "FAILED  stop: heartbeat  the amplifier is off only",
    ),
];

/// Fault 7.
/// Hazard 15.
#[test]
fn a_bench_that_its_stops_do_not_stop_is_not_driven() {
    for (defect, row) in DEFECTS {
        let (folder, study) = room();
        let scenario = scenario(folder.path(), defect);
        let mut run = bench();
        run.args([
            "run",
            "--headless",
            "--speed",
            "max",
            "--participant",
            "sub-01",
        ])
        .args(["--consent-by", "A. Tester", "--study"])
        .arg(&study)
        .arg("--mock")
        .arg(&scenario);
        assert_early_refusal(&mut run, &study, &[row]);

        for arguments in [
            &[
                "monitor",
                "--headless",
                "--drive-v",
                "20",
                "--duration-s",
                "1",
            ][..],
            &["calibrate", "plate", "--operator", "ME"],
            &["calibrate", "pickup", "--operator", "ME"],
            &["calibrate", "channels", "--operator", "ME"],
        ] {
            let mut command = bench();
            command
                .current_dir(folder.path())
                .args(arguments)
                .args(["--speed", "max", "--mock"])
                .arg(&scenario);
            assert_refusal(&finish(&mut command), &[row]);
        }
    }
}

#[test]
fn a_session_logs_how_long_its_stops_took() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_TRIAL);
    let output = finish(&mut headless_run(&study, "sub-01", protocol));
    assert!(output.status.success(), "{}", text(&output));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let rows = session.starts()[0].preflight.as_array().unwrap();
    for name in ["stop: heartbeat", "stop: enable"] {
        let row = rows.iter().find(|row| row["name"] == name).unwrap();
        assert_eq!(row["passed"], true, "{row}");
        assert!(row["found"].as_str().unwrap().contains("ms after"), "{row}");
    }
}

/// Hazard 16.
#[test]
fn a_real_bench_drives_only_after_its_e_stop_was_pressed() {
    let (folder, study) = room();
    let changes = [
        SOUND_CARD,
        (
            "backend = \"none\"",
            "backend = \"rppal\"\nestop = 13\nheartbeat = 21",
        ),
    ];
    let config = write_bench_config(folder.path(), &changes);
    let mut run = uncalibrated(&study, &config);
    run.current_dir(folder.path());
    assert_early_refusal(
        &mut run,
        &study,
        &["never been tested", "check --press-estop"],
    );

    let record = |press_time: jiff::Timestamp, line: &str| {
        let path = record_path(&folder.path().join("calibration.toml"));
        EstopPress::record(&path, line.to_owned(), press_time).unwrap();
    };
    let now = jiff::Timestamp::now();
    let hours = |hours: i64| jiff::SignedDuration::from_hours(hours);
    for (press_time, line, word) in [
        (now - hours(25), "rppal, line 13", "25.0 hours ago"),
        (now, "rppal, line 14", "was tested on rppal, line 14"),
        (now + hours(2), "rppal, line 13", "in the future"),
        // This machine has no such line, but the press is recent.
        (now - hours(1), "rppal, line 13", "Raspberry Pi"),
    ] {
        record(press_time, line);
        let mut run = uncalibrated(&study, &config);
        run.current_dir(folder.path());
        assert_early_refusal(&mut run, &study, &[word]);
    }
}

#[test]
fn a_press_is_rehearsed_on_the_simulated_bench() {
    let (folder, _) = room();
    let mut check = bench();
    check
        .current_dir(folder.path())
        .args(["check", "--mock", "--quick", "--press-estop"]);
    let output = finish(&mut check);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    for word in ["Press the e-stop now.", "Release it.", "The e-stop works"] {
        assert!(transcript.contains(word), "{transcript}");
    }
    // Such a record would count for the real bench that the configuration names.
    assert!(!folder.path().join("calibration-estop.toml").exists());
}
