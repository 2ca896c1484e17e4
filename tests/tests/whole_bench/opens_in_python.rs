//! A trial's files open with scipy and pandas alone, and have the content described in RECORDING.md.

use std::process::Command;

use bench_tests::program::{python, workspace};
use bench_tests::recorded::Recording;
use bench_tests::session::{SessionFolder, finish, headless_run, text, write_demo_protocol};
use serde_json::{Value, json};

#[test]
fn a_trial_opens_in_scipy_and_pandas() {
    let python = python();
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let protocol = write_demo_protocol(
        folder.path(),
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
            ("baseline_s = 0.8", "baseline_s = 1.5"),
        ],
    );
    let output = finish(&mut headless_run(&study, "sub-01", &protocol));
    assert!(output.status.success(), "{}", text(&output));
    let path = SessionFolder::read(&study, "sub-01")
        .unwrap()
        .recordings()
        .remove(0);
    let recording = Recording::read(&path);
    let channels = &recording.manifest.signals().unwrap().channels;
    let output = finish(
        Command::new(&python)
            .arg(workspace().join("tests/python/read_trial.py"))
            .arg(&path)
            .args([channels.drive.index, channels.pickup.index].map(|index| index.to_string())),
    );
    assert!(output.status.success(), "{}", text(&output));
    // A reader that does not know a chunk would print a warning.
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    let content: Value = serde_json::from_slice(&output.stdout).unwrap();
    let number = |pointer: &str| {
        content
            .pointer(pointer)
            .and_then(Value::as_f64)
            .unwrap_or_else(|| panic!("no {pointer} in {content}"))
    };

    assert_eq!(content["rate_hz"], 192_000);
    assert_eq!(content["type"], "float32");
    assert_eq!(content["channels"], 4);
    assert_eq!(content["frames"], recording.frames());
    assert_eq!(content["nan"], 0);
    assert!((0.5..1.0).contains(&number("/greatest")), "{content}");

    // 24 V mean amplitude at 60 V per unit, with sidebands of half the modulation index.
    assert_eq!(content["drive"]["strongest_hz"], 35_000, "{content}");
    let drive_v = number("/drive/amplitude") * channels.drive.volts_per_unit;
    assert!((drive_v - 24.0).abs() < 0.5, "{drive_v} V");
    for sideband in ["lower", "upper"] {
        let index = 2.0 * number(&format!("/drive/{sideband}"));
        assert!((index - 0.95).abs() < 0.01, "modulation index {index}");
    }
    // |x̃| = γU/(ωb_p) on the bare plate, about 2 µm.
    assert_eq!(content["pickup"]["strongest_hz"], 35_000, "{content}");
    let amplitude_m = number("/pickup/amplitude") * channels.pickup.metres_per_unit;
    let expected_m = 0.13 * 24.0 / (std::f64::consts::TAU * 35_000.0 * 7.01);
    assert!(
        (amplitude_m / expected_m - 1.0).abs() < 0.05,
        "{amplitude_m} m, not {expected_m}"
    );

    for (file, columns, rate_hz) in [
        (
            "force",
            json!(["time_s", "normal_n", "lateral_n"]),
            10_000.0,
        ),
        ("position", json!(["time_s", "position_m"]), 1_000.0),
    ] {
        let table = &content[file];
        assert_eq!(table["columns"], columns);
        assert_eq!(table["numeric"], true, "{file}");
        assert_eq!(table["missing"], 0, "{file}");
        assert_eq!(table["rising"], true, "{file}");
        let measured_hz = table["rate_hz"].as_f64().unwrap();
        assert!(
            (measured_hz / rate_hz - 1.0).abs() < 0.01,
            "{file} at {measured_hz} Hz"
        );
    }
    assert!(
        (0.5..0.8).contains(&number("/median_touching_n")),
        "{content}"
    );
    assert!(number("/greatest_normal_n") < 2.0, "{content}");
    assert!(
        number("/position_from_m") > -0.001 && number("/position_to_m") < 0.105,
        "{content}"
    );
    assert!(
        number("/position_to_m") - number("/position_from_m") > 0.07,
        "{content}"
    );
}
