//! Sessions of early versions, resumed after recordings of accepted trials were lost.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;

use bench_tests::program::bench;
use bench_tests::session::{finish, text};
use recording::MANIFEST_FILE;
use serde_json::Value;

use super::verify::{Copied, TRIAL};

const SECOND: &str = "trial-002_attempt-1";

/// Cuts the log off after the line that settles the trial with this number in the session's order.
fn killed_after(study: &Copied, number: u32) {
    edit_log(study, |lines| {
        let settles = |line: &Value| {
            let data = &line["data"];
            data["event"] == "trial_settled" && data["record"]["key"]["number"] == number
        };
        let last = lines.iter().rposition(settles).unwrap();
        lines.truncate(last + 1);
    });
}

/// Turns a trial into one that an early version accepted although its recording was interrupted and never reported as saved.
fn broken_off(study: &Copied, trial: &str) {
    edit_log(study, |lines| {
        let before = lines.len();
        lines.retain(|line| line["data"]["saved"] != trial);
        assert_eq!(lines.len(), before - 1);
    });
    study.edit(
        &study.session().join(trial).join(MANIFEST_FILE),
        "end = \"completed\"",
        "end = \"interrupted\"",
    );
}

/// Edits the log and renumbers its events.
fn edit_log(study: &Copied, edit: impl Fn(&mut Vec<Value>)) {
    let log = study.session().join("events.jsonl");
    let text = fs::read_to_string(&log).unwrap();
    let mut lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    edit(&mut lines);
    let events = lines.iter_mut().filter(|line| line["document"] == "event");
    for (index, line) in events.enumerate() {
        line["seq_num"] = (index + 1).into();
    }
    let edited: String = lines.iter().map(|line| format!("{line}\n")).collect();
    fs::write(log, edited).unwrap();
}

/// Requires the study to be whole, with two trials accepted and analysed.
fn require_two(study: &Copied) {
    let (status, printed) = study.verify();
    assert_eq!(status, 0, "{printed}");
    assert!(printed.contains("complete, 2 of 2"), "{printed}");
    let analyzed = finish(bench().arg("analyze").arg(study.study()));
    let printed = text(&analyzed);
    assert!(analyzed.status.success(), "{printed}");
    assert!(printed.contains("accepted 2, analysed 2"), "{printed}");
}

/// Fault 27.
#[test]
fn the_last_accepted_trial_is_repeated_if_its_recording_is_lost() {
    let study = Copied::new();
    killed_after(&study, 2);
    fs::remove_dir_all(study.session().join(SECOND)).unwrap();
    broken_off(&study, TRIAL);
    let resumed = study.resume(&[]);
    let printed = text(&resumed);
    assert!(resumed.status.success(), "{printed}");
    let told = format!("the recording of {TRIAL} is lost");
    for words in [&told[..], "counts as interrupted and is repeated"] {
        assert!(printed.contains(words), "no `{words}` in:\n{printed}");
    }
    let log = fs::read_to_string(study.session().join("events.jsonl")).unwrap();
    let not_saved = log.lines().filter(|line| line.contains("\"not_saved\""));
    assert_eq!(not_saved.count(), 1);
    require_two(&study);
}

/// Fault 27.
#[test]
fn recordings_that_were_moved_are_asked_for_and_repeated_only_by_the_operators_word() {
    // The recordings were moved, and are moved back.
    let study = Copied::new();
    killed_after(&study, 3);
    let (there, elsewhere) = (study.session().join(TRIAL), study.study().join("moved"));
    fs::rename(&there, &elsewhere).unwrap();
    let log = study.session().join("events.jsonl");
    let before = fs::read(&log).unwrap();
    let refused = study.resume(&[]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    for words in [
        TRIAL,
        "its folder is missing",
        "put them back",
        "--repeat-lost",
    ] {
        let printed = text(&refused);
        assert!(printed.contains(words), "no `{words}` in:\n{printed}");
    }
    assert!(!text(&refused).contains(SECOND), "{}", text(&refused));
    assert_eq!(fs::read(&log).unwrap(), before);
    fs::rename(&elsewhere, &there).unwrap();
    let resumed = study.resume(&[]);
    assert!(resumed.status.success(), "{}", text(&resumed));
    assert!(!text(&resumed).contains("is lost"), "{}", text(&resumed));
    require_two(&study);

    // The recordings are lost, because the recorder hung.
    let study = Copied::new();
    killed_after(&study, 3);
    broken_off(&study, TRIAL);
    broken_off(&study, SECOND);
    let refused = study.resume(&[]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    for trial in [TRIAL, SECOND] {
        assert!(text(&refused).contains(trial), "{}", text(&refused));
    }
    let resumed = study.resume(&["--repeat-lost"]);
    assert!(resumed.status.success(), "{}", text(&resumed));
    require_two(&study);
}
