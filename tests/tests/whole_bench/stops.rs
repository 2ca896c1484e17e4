//! The hardware stops are exercised before anything drives: a bench that they do not stop is not driven.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::{Path, PathBuf};

use bench_tests::program::bench;
use bench_tests::session::{SessionFolder, demo_with, finish, text, unattended};

use super::refusals::{refused, refused_before_anything_is_made, room};

fn scenario(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("scenario.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// Benches that a stop does not stop, and the row that says so.
const UNSTOPPABLE: [(&str, &str); 2] = [
    (
        "[amplifier]\none_shot_s = 5.0\n",
        "FAILED  stop: heartbeat  the amplifier stays on",
    ),
    (
        "[amplifier]\none_shot_s = 0.25\n",
        "FAILED  stop: heartbeat  the amplifier is off only",
    ),
];

#[test]
fn a_bench_that_its_stops_do_not_stop_is_not_driven() {
    for (faulty, row) in UNSTOPPABLE {
        let (folder, study) = room();
        let scenario = scenario(folder.path(), faulty);
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
        refused_before_anything_is_made(&mut run, &study, &[row]);

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
            refused(&finish(&mut command), &[row]);
        }
    }
}

#[test]
fn a_session_logs_how_long_its_stops_took() {
    let (folder, study) = room();
    let protocol = demo_with(
        folder.path(),
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
        ],
    );
    let ended = finish(&mut unattended(&study, "sub-01", protocol));
    assert!(ended.status.success(), "{}", text(&ended));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let rows = session.starts()[0].preflight.as_array().unwrap();
    for name in ["stop: heartbeat", "stop: enable"] {
        let row = rows.iter().find(|row| row["name"] == name).unwrap();
        assert_eq!(row["passed"], true, "{row}");
        assert!(row["found"].as_str().unwrap().contains("ms after"), "{row}");
    }
}
