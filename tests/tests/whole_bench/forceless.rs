//! A bench without a force sensor: its functions, and its messages about those that need a sensor.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::{Path, PathBuf};

use bench_tests::program::bench;
use bench_tests::session::{finish, text};

/// Writes the simulated bench's configuration without its table `[force]`.
fn forceless(folder: &Path) -> PathBuf {
    let text = include_str!("../../../bench/mock-bench.toml");
    let (before, rest) = text.split_once("[force]\n").unwrap();
    let after = rest.split_once("\n[").unwrap().1;
    let path = folder.join("bench.toml");
    std::fs::write(&path, format!("{before}[{after}")).unwrap();
    path
}

#[test]
fn a_bench_without_a_force_sensor_says_what_it_can_do_and_does_it() {
    let folder = tempfile::tempdir().unwrap();
    let config = forceless(folder.path());
    let calibration = folder.path().join("calibration.toml");
    let said = |words: &[&str], passes: bool| {
        let mut command = bench();
        command
            .args(words)
            .args(["--mock", "--config"])
            .arg(&config)
            .current_dir(folder.path());
        let output = finish(&mut command);
        let said = text(&output);
        assert_eq!(output.status.success(), passes, "{words:?}: {said}");
        assert!(!said.contains("NaN"), "{words:?}: {said}");
        said
    };
    let free = ["--headless", "--speed", "max"];
    let with = |words: &[&'static str]| [words, &free[..]].concat();

    let monitor = with(&["monitor", "--duration-s", "2", "--drive-v", "10"]);
    let watched = said(&monitor, true);
    for word in [
        "no force sensor ([force] in bench.toml)",
        "normal –  drift",
        "Z_m 7.0",
    ] {
        assert!(watched.contains(word), "no `{word}` in {watched}");
    }
    let checked = said(&["check"], true);
    assert!(checked.contains("warning force sensor"), "{checked}");
    let path = calibration.to_str().unwrap();
    for what in ["pickup", "plate"] {
        let words = ["calibrate", what, "--operator", "T", "--calibration", path];
        let measured = said(&[&words[..], &free[..]].concat(), true);
        let word = "nothing but you tells whether the plate is clear";
        assert!(measured.contains(word), "{measured}");
    }
    let words = [
        "calibrate",
        "force",
        "--operator",
        "T",
        "--normal-g",
        "20,50",
    ];
    let refused = said(
        &[&words[..], &["--lateral-g", "20,50"], &free[..]].concat(),
        false,
    );
    assert!(refused.contains("describe it as [force]"), "{refused}");
    let session = [
        "run",
        "--participant",
        "sub-01",
        "--consent-by",
        "A. Tester",
        "--protocol",
        "demo",
        "--study",
        "study",
    ];
    let refused = said(&[&session[..], &free[..]].concat(), false);
    for word in ["[force] of bench.toml", "`monitor`"] {
        assert!(refused.contains(word), "no `{word}` in {refused}");
    }
}
