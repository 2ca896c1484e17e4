//! A plate with a resonance that drifts during a session, and a carrier that follows it between trials.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;

use bench_tests::program::bench;
use bench_tests::session::{SessionFolder, demo_with, finish, text};
use recording::Manifest;

/// Runs two short trials while the room moves the resonance by 30 Hz/min.
fn session(new_carrier: &str) -> (SessionFolder, String, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("drifts.toml");
    let drifts = "purpose = \"drifts\"\n[plate.drift]\nroom_hz_per_min = 30.0\n";
    std::fs::write(&scenario, drifts).unwrap();
    let short = [
        ("practice = 1", "practice = 0"),
        ("per_condition = 4", "per_condition = 2"),
        ("\"left_to_right\", \"right_to_left\"", "\"left_to_right\""),
        ("limit_hz = 5.0", "limit_hz = 2.0"),
        ("new_carrier = \"ask\"", new_carrier),
        ("max_per_trial = 3", "max_per_trial = 0"),
    ];
    demo_with(folder.path(), &short);
    let (session, printed) = run(folder.path(), &[]);
    (session, printed, folder)
}

fn run(folder: &Path, more: &[&str]) -> (SessionFolder, String) {
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
        .args(more);
    let output = finish(&mut command);
    let printed = text(&output);
    assert!(output.status.success(), "{printed}");
    (SessionFolder::read(&study, "sub-01").unwrap(), printed)
}

/// Puts the session into the state that a kill before its second trial leaves.
fn kill_before_the_second_trial(session: &Path) {
    let log = session.join("events.jsonl");
    let text = std::fs::read_to_string(&log).unwrap();
    let trials = text.match_indices("\"trial_began\"");
    let second = trials.map(|(at, _)| at).nth(1).unwrap();
    let end = text[..second].rfind('\n').unwrap() + 1;
    std::fs::write(&log, &text[..end]).unwrap();
    std::fs::remove_dir_all(session.join("trial-002_attempt-1")).unwrap();
}

fn manifests(session: &SessionFolder) -> Vec<Manifest> {
    let mut folders = session.recordings();
    folders.sort();
    let read = |folder: std::path::PathBuf| {
        let text = std::fs::read_to_string(folder.join("recording.toml")).unwrap();
        Manifest::parse(&text, "recording.toml").unwrap()
    };
    folders.into_iter().map(read).collect()
}

/// Fault 45.
#[test]
fn the_carrier_follows_the_resonance_between_trials_if_the_protocol_says_so() {
    let (session, _, folder) = session("new_carrier = \"auto\"");
    let changed: Vec<_> = session.named("carrier_changed").collect();
    let [changed] = &changed[..] else {
        panic!("{changed:?}");
    };
    let number = |key: &str| changed.data[key].as_f64().unwrap();
    assert_eq!(changed.data["by"], "protocol");
    let (from_hz, to_hz) = (number("from_hz"), number("to_hz"));
    assert!((number("drift_hz") - (to_hz - from_hz)).abs() <= 0.5);
    let [first, second] = &manifests(&session)[..] else {
        panic!("two trials");
    };
    assert_eq!((first.carrier_hz, second.carrier_hz), (from_hz, to_hz));
    assert_eq!(second.plate.resonance_hz, to_hz);
    // The drift continues, and is measured from the new carrier.
    let fits: Vec<_> = session.named("fit").collect();
    assert_eq!(fits.len(), 2);
    let drift_hz = fits[1].data["plate_drift_hz"].as_f64().unwrap();
    let trials_apart_s = fits[1].audio_s - changed.audio_s;
    assert!(
        (drift_hz - 0.5 * trials_apart_s).abs() < 1.0,
        "{drift_hz} {trials_apart_s}"
    );

    // When resumed, the session uses the new carrier and the skin estimated before.
    assert_eq!(fits[1].data["skin"]["trials"], 2);
    kill_before_the_second_trial(&folder.path().join("study/sub-01/ses-01"));
    let (resumed, printed) = run(folder.path(), &["--resume"]);
    let changed: Vec<_> = resumed.named("carrier_changed").collect();
    assert_eq!(changed.len(), 2);
    assert_eq!(changed[1].data["by"], "resumed session");
    assert_eq!(changed[1].data["to_hz"].as_f64(), Some(to_hz));
    let [first, second] = &manifests(&resumed)[..] else {
        panic!("two trials");
    };
    assert_eq!((first.carrier_hz, second.carrier_hz), (from_hz, to_hz));
    let fits: Vec<_> = resumed.named("fit").collect();
    assert_eq!(fits.len(), 2);
    assert_eq!(fits[1].data["skin"]["trials"], 2);
    assert!(printed.contains(", of 1 trial"), "{printed}");
}

#[test]
fn without_an_operator_a_carrier_that_is_to_be_asked_for_stays() {
    let (session, printed, _folder) = session("new_carrier = \"ask\"");
    let kept: Vec<_> = session.named("carrier_kept").collect();
    assert_eq!(kept.len(), 1);
    assert_eq!(kept[0].data["because"], "nobody to ask");
    assert_eq!(session.named("carrier_changed").count(), 0);
    assert!(printed.contains("nobody is here to confirm"), "{printed}");
    let manifests = manifests(&session);
    assert_eq!(manifests[0].carrier_hz, manifests[1].carrier_hz);
}
