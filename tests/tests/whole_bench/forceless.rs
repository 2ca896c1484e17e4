//! A bench without a force sensor: its functions, and its messages about those that need a sensor.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::{Path, PathBuf};

use bench_tests::program::bench;
use bench_tests::session::{finish, text};

/// Writes the simulated bench's configuration without its table `[force]`.
fn config_without_force(folder: &Path) -> PathBuf {
    let text = config::rigs::MOCK_BENCH;
    let (head, tail) = text.split_once("[force]\n").unwrap();
    let remainder = tail.split_once("\n[").unwrap().1;
    let path = folder.join("bench.toml");
    std::fs::write(&path, format!("{head}[{remainder}")).unwrap();
    path
}

#[test]
fn a_bench_without_a_force_sensor_refuses_only_commands_that_need_one() {
    let folder = tempfile::tempdir().unwrap();
    let config = config_without_force(folder.path());
    let calibration = folder.path().join("calibration.toml");
    let run = |words: &[&str], is_success: bool| {
        let mut command = bench();
        command
            .args(words)
            .args(["--mock", "--config"])
            .arg(&config)
            .current_dir(folder.path());
        let output = finish(&mut command);
        let transcript = text(&output);
        assert_eq!(
            output.status.success(),
            is_success,
            "{words:?}: {transcript}"
        );
        assert!(!transcript.contains("NaN"), "{words:?}: {transcript}");
        transcript
    };
    let flags = ["--headless", "--speed", "max"];
    let words_with_flags = |words: &[&'static str]| [words, &flags[..]].concat();

    let monitor = words_with_flags(&["monitor", "--duration-s", "2", "--drive-v", "10"]);
    let monitor_output = run(&monitor, true);
    for word in [
        "no force sensor ([force] in bench.toml)",
        "normal –  drift",
        "Z_m 7.0",
    ] {
        assert!(
            monitor_output.contains(word),
            "no `{word}` in {monitor_output}"
        );
    }
    let transcript = run(&["check", "--protocol", "demo"], true);
    assert!(transcript.contains("warning force sensor"), "{transcript}");
    let path = calibration.to_str().unwrap();
    for part in ["pickup", "plate"] {
        let words = ["calibrate", part, "--operator", "T", "--calibration", path];
        let transcript = run(&[&words[..], &flags[..]].concat(), true);
        let word = "only you can see whether the plate is clear";
        assert!(transcript.contains(word), "{transcript}");
    }
    let words = [
        "calibrate",
        "force",
        "--operator",
        "T",
        "--normal-g",
        "20,50",
    ];
    let transcript = run(
        &[&words[..], &["--lateral-g", "20,50"], &flags[..]].concat(),
        false,
    );
    assert!(
        transcript.contains("describe it as [force]"),
        "{transcript}"
    );
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
    let transcript = run(&[&session[..], &flags[..]].concat(), false);
    for word in ["[force] of bench.toml", "`monitor`"] {
        assert!(transcript.contains(word), "no `{word}` in {transcript}");
    }
}
