//! Sessions from the command line to results, by `bench.toml`, with each source of forces other than a plain serial line.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::Path;

use bench_tests::program::bench;
use bench_tests::recorded::Recording;
use bench_tests::session::{SessionFolder, finish, text, write_demo_protocol};
use mock_world::plant::MAKERS_MATRIX;
use recording::manifest::ClockDevice;
use serde_json::Value;

/// Runs and analyses a session of one trial on the simulated bench of `scenario` with the `bench.toml` that it prints; returns
/// the interface of the force sensor according to the recording.
fn session(scenario: &str, change: fn(&Path, String) -> String) -> String {
    let (recording, _) = results(scenario, change);
    recording.manifest.hardware.unwrap().force_sensor.unwrap()
}

/// Does the same as [`session`]; returns the recording and its results.
fn results(scenario: &str, change: fn(&Path, String) -> String) -> (Recording, Value) {
    let room = tempfile::tempdir().unwrap();
    let folder = room.path();
    let output = finish(bench().args(["run", "--mock", scenario, "--print-config"]));
    assert!(output.status.success(), "{}", text(&output));
    let config = folder.join("bench.toml");
    let config_text = change(folder, String::from_utf8(output.stdout).unwrap());
    fs::write(&config, config_text).unwrap();
    let protocol = write_demo_protocol(
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
    let output = finish(&mut run);
    assert!(output.status.success(), "{}", text(&output));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    session.require_whole();
    let recordings = session.recordings();
    let recording = Recording::read(&recordings[0]);
    let results = folder.join("results.json");
    let output = finish(
        bench()
            .arg("analyze")
            .arg(&study)
            .arg("--json")
            .arg(&results),
    );
    assert!(output.status.success(), "{}", text(&output));
    let results: Value = serde_json::from_slice(&fs::read(&results).unwrap()).unwrap();
    let instances = results["recordings"][0]["instances"].as_array().unwrap();
    assert!(instances.len() >= 5, "{} instances", instances.len());
    (recording, results)
}

/// Fault 40.
#[test]
fn a_session_with_forces_from_the_network_leads_to_results() {
    assert_eq!(session("net-ft", |_, config| config), "netft");
}

/// Fault 41.
#[test]
fn a_session_behind_a_field_box_leads_to_results_and_names_the_box() {
    let sensor = session("field-box", |_, config| {
        assert!(config.contains("backend = \"field-box\""), "{config}");
        config
    });
    assert_eq!(
        sensor,
        "field-box, 513D0073696D756C, firmware 0.1.0, 4000 Hz"
    );
}

/// Fault 41.
/// Hazard 15.
#[test]
fn a_session_behind_a_field_box_is_driven_while_the_switch_at_the_box_is_held() {
    session("field-box", |_, config| {
        let config_with_switch = config.replace("[safety]\n", "[safety]\ndead_man = \"button\"\n");
        assert_ne!(config_with_switch, config);
        config_with_switch
    });
}

/// Writes the manufacturer's calibration file into a folder, and makes the configuration use it instead of the matrix.
fn use_makers_file(folder: &Path, config: String) -> String {
    let axes = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
        .iter()
        .zip(MAKERS_MATRIX);
    let rows: String = axes
        .map(|(axis, values)| {
            let values = values.map(|value| value.to_string()).join("   ");
            format!("    <UserAxis Name=\"{axis}\" values=\"  {values} \" max=\"12\"/>\n")
        })
        .collect();
    let file = format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<FTSensor Serial=\"FT00001\" NumGages=\"6\" CalFileVersion=\"1.1\">\n  \
         <Calibration ForceUnits=\"N\" TorqueUnits=\"N-m\" GainMultiplier=\"1\">\n{rows}  </Calibration>\n</FTSensor>\n"
    );
    fs::write(folder.join("FT00001.cal"), file).unwrap();
    let (head, tail) = config.split_once("newtons_per_v = [").unwrap();
    let (_, end) = tail.split_once("\n]\n").unwrap();
    format!("{head}cal_file = \"FT00001.cal\"\n{end}")
}

/// Fault 46.
#[test]
fn a_session_with_forces_from_inputs_of_the_card_and_the_makers_file_leads_to_results() {
    assert_eq!(session("gauges", use_makers_file), "channels");
}

/// Fault 24.
#[test]
fn a_session_with_a_resonators_clock_finds_the_friction_that_is_there() {
    let room = tempfile::tempdir().unwrap();
    let scenario = room.path().join("resonator.toml");
    let arduino = include_str!("../../../mock-hw/world/scenarios/arduino.toml");
    fs::write(&scenario, format!("{arduino}clock_ppm = 9000.0\n")).unwrap();
    let (recording, results) = results(scenario.to_str().unwrap(), |_, config| config);
    let clocks = recording.manifest.clocks;
    let sensor = clocks
        .iter()
        .find(|clock| clock.of == ClockDevice::ForceSensor);
    assert!(
        (sensor.unwrap().drift_ppm - 9000.0).abs() < 50.0,
        "{clocks:?}"
    );
    for instance in results["recordings"][0]["instances"].as_array().unwrap() {
        let estimate = &instance["trial"];
        let (mu0, spearman) = (&estimate["mu0"], &estimate["spearman_mu"]);
        assert!((mu0.as_f64().unwrap() - 0.88).abs() < 0.03, "{mu0}");
        assert!(spearman.as_f64().unwrap() > 0.99, "{spearman}");
    }
}
