//! A session from the command line to results, with each source of forces that is no serial line, by its `bench.toml`.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;

use bench_tests::program::bench;
use bench_tests::recorded::Recording;
use bench_tests::session::{SessionFolder, demo_with, finish, text};
use serde_json::Value;

/// Runs a session of one trial on the simulated bench of `scenario` with the `bench.toml` that it prints, and analyses it;
/// returns how the recording says its forces came.
fn session(scenario: &str) -> String {
    let room = tempfile::tempdir().unwrap();
    let folder = room.path();
    let printed = finish(bench().args(["run", "--mock", scenario, "--print-config"]));
    assert!(printed.status.success(), "{}", text(&printed));
    let config = folder.join("bench.toml");
    fs::write(&config, &printed.stdout).unwrap();
    let protocol = demo_with(
        folder,
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
            (
                "[\"left_to_right\", \"right_to_left\"]",
                "[\"left_to_right\"]",
            ),
        ],
    );
    let study = folder.join("study");
    let mut run = bench();
    run.args(["run", "--headless", "--speed", "max", "--mock", scenario])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--config")
        .arg(&config)
        .arg("--protocol")
        .arg(&protocol)
        .arg("--study")
        .arg(&study);
    let ran = finish(&mut run);
    assert!(ran.status.success(), "{}", text(&ran));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    session.require_whole();
    let recordings = session.recordings();
    let recording = Recording::read(&recordings[0]);
    let results = folder.join("results.json");
    let analysed = finish(
        bench()
            .arg("analyze")
            .arg(&study)
            .arg("--json")
            .arg(&results),
    );
    assert!(analysed.status.success(), "{}", text(&analysed));
    let results: Value = serde_json::from_slice(&fs::read(&results).unwrap()).unwrap();
    let instances = results["recordings"][0]["instances"].as_array().unwrap();
    assert!(instances.len() >= 5, "{} instances", instances.len());
    recording.manifest.hardware.unwrap().force_sensor.unwrap()
}

/// Fault 40.
#[test]
fn a_session_with_forces_from_the_network_leads_to_results() {
    assert_eq!(session("net-ft"), "netft");
}
