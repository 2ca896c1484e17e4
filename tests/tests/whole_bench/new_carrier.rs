//! A plate with a resonance that drifts during a session, and a carrier that follows it between trials.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;

use bench_tests::program::bench;
use bench_tests::session::{SessionFolder, finish, text, write_demo_protocol};
use recording::Manifest;

/// Runs two short trials while the room moves the resonance by 30 Hz/min.
fn session(new_carrier: &str) -> (SessionFolder, String, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("drifts.toml");
    let scenario_text = "purpose = \"drifts\"\n[plate.drift]\nroom_hz_per_min = 30.0\n";
    std::fs::write(&scenario, scenario_text).unwrap();
    let changes = [
        ("practice = 1", "practice = 0"),
        ("per_condition = 4", "per_condition = 2"),
        ("\"left_to_right\", \"right_to_left\"", "\"left_to_right\""),
        ("limit_hz = 5.0", "limit_hz = 2.0"),
        ("new_carrier = \"ask\"", new_carrier),
        ("max_per_trial = 3", "max_per_trial = 0"),
    ];
    write_demo_protocol(folder.path(), &changes);
    let (session, transcript) = run(folder.path(), &[]);
    (session, transcript, folder)
}

fn run(folder: &Path, options: &[&str]) -> (SessionFolder, String) {
    let study = folder.join("study");
    let mut command = bench();
    command
        .args(["run", "--headless", "--speed", "max", "--mock"])
        .arg(folder.join("drifts.toml"))
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--protocol")
        .arg(folder.join("protocol.toml"))
        .arg("--study")
        .arg(&study)
        .args(options);
    let output = finish(&mut command);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    (SessionFolder::read(&study, "sub-01").unwrap(), transcript)
}

/// Puts the session into the state that a kill before its second trial leaves.
fn kill_before_the_second_trial(session: &Path) {
    let log = session.join("events.jsonl");
    let text = std::fs::read_to_string(&log).unwrap();
    let trials = text.match_indices("\"trial_began\"");
    let offset = trials.map(|(index, _)| index).nth(1).unwrap();
    let end = text[..offset].rfind('\n').unwrap() + 1;
    std::fs::write(&log, &text[..end]).unwrap();
    std::fs::remove_dir_all(session.join("trial-002_attempt-1")).unwrap();
}

fn manifests(session: &SessionFolder) -> Vec<Manifest> {
    let mut folders = session.recordings();
    folders.sort();
    let manifest = |folder: std::path::PathBuf| {
        let text = std::fs::read_to_string(folder.join("recording.toml")).unwrap();
        Manifest::parse(&text, "recording.toml").unwrap()
    };
    folders.into_iter().map(manifest).collect()
}

/// Fault 45.
#[test]
fn the_carrier_follows_the_resonance_between_trials_if_the_protocol_says_so() {
    let (session, _, folder) = session("new_carrier = \"auto\"");
    let events: Vec<_> = session.named("carrier_changed").collect();
    let [event] = &events[..] else {
        panic!("{events:?}");
    };
    let number = |key: &str| event.data[key].as_f64().unwrap();
    assert_eq!(event.data["by"], "protocol");
    let (from_hz, to_hz) = (number("from_hz"), number("to_hz"));
    assert!((number("drift_hz") - (to_hz - from_hz)).abs() <= 0.5);
    let [first_manifest, second_manifest] = &manifests(&session)[..] else {
        panic!("two trials");
    };
    assert_eq!(
        (first_manifest.carrier_hz(), second_manifest.carrier_hz()),
        (Some(from_hz), Some(to_hz))
    );
    assert_eq!(second_manifest.plate().unwrap().resonance_hz, to_hz);
    // The drift continues, and is measured from the new carrier.
    let fits: Vec<_> = session.named("fit").collect();
    assert_eq!(fits.len(), 2);
    let drift_hz = fits[1].data["plate_drift_hz"].as_f64().unwrap();
    let delay_s = fits[1].audio_s - event.audio_s;
    assert!(
        (drift_hz - 0.5 * delay_s).abs() < 1.0,
        "{drift_hz} {delay_s}"
    );

    // When resumed, the session uses the new carrier and the skin estimated before.
    assert_eq!(fits[1].data["skin"]["trials"], 2);
    kill_before_the_second_trial(&folder.path().join("study/sub-01/ses-01"));
    let (resumed_session, transcript) = run(folder.path(), &["--resume"]);
    let events: Vec<_> = resumed_session.named("carrier_changed").collect();
    assert_eq!(events.len(), 2);
    assert_eq!(events[1].data["by"], "resumed session");
    assert_eq!(events[1].data["to_hz"].as_f64(), Some(to_hz));
    let [first_manifest, second_manifest] = &manifests(&resumed_session)[..] else {
        panic!("two trials");
    };
    assert_eq!(
        (first_manifest.carrier_hz(), second_manifest.carrier_hz()),
        (Some(from_hz), Some(to_hz))
    );
    let fits: Vec<_> = resumed_session.named("fit").collect();
    assert_eq!(fits.len(), 2);
    assert_eq!(fits[1].data["skin"]["trials"], 2);
    assert!(transcript.contains(", of 1 trial"), "{transcript}");
}

#[test]
fn a_carrier_change_without_an_operator_is_not_made() {
    let (session, transcript, _folder) = session("new_carrier = \"ask\"");
    let events: Vec<_> = session.named("carrier_kept").collect();
    assert_eq!(events.len(), 1);
    assert_eq!(events[0].data["because"], "nobody to ask");
    assert_eq!(session.named("carrier_changed").count(), 0);
    assert!(
        transcript.contains("no operator can confirm"),
        "{transcript}"
    );
    let manifests = manifests(&session);
    assert_eq!(manifests[0].carrier_hz(), manifests[1].carrier_hz());
}
