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

use super::verify::{StudyCopy, TRIAL};

const SECOND: &str = "trial-002_attempt-1";

/// Cuts the log off after the line that settles the trial with this number in the session's order.
fn cut_log_after(study: &StudyCopy, number: u32) {
    edit_log(study, |lines| {
        let is_settled = |line: &Value| {
            let data = &line["data"];
            data["event"] == "trial_settled" && data["record"]["key"]["number"] == number
        };
        let index = lines.iter().rposition(is_settled).unwrap();
        lines.truncate(index + 1);
    });
}

/// Turns a trial into one that an early version accepted although its recording was interrupted and never reported as saved.
fn interrupt_recording(study: &StudyCopy, trial: &str) {
    edit_log(study, |lines| {
        let count = lines.len();
        lines.retain(|line| line["data"]["saved"] != trial);
        assert_eq!(lines.len(), count - 1);
    });
    study.edit(
        &study.session().join(trial).join(MANIFEST_FILE),
        "end = \"completed\"",
        "end = \"interrupted\"",
    );
}

/// Edits the log and renumbers its events.
fn edit_log(study: &StudyCopy, edit: impl Fn(&mut Vec<Value>)) {
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
    let content: String = lines.iter().map(|line| format!("{line}\n")).collect();
    fs::write(log, content).unwrap();
}

/// Requires the study to be whole, with two trials accepted and analysed.
fn require_two(study: &StudyCopy) {
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    assert!(transcript.contains("complete, 2 of 2"), "{transcript}");
    let output = finish(bench().arg("analyze").arg(study.study()));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(
        transcript.contains("accepted 2, analysed 2"),
        "{transcript}"
    );
}

/// Fault 27.
#[test]
fn the_last_accepted_trial_is_repeated_if_its_recording_is_lost() {
    let study = StudyCopy::new();
    cut_log_after(&study, 2);
    fs::remove_dir_all(study.session().join(SECOND)).unwrap();
    interrupt_recording(&study, TRIAL);
    let output = study.resume(&[]);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    let message = format!("the recording of {TRIAL} is lost");
    for words in [&message[..], "counts as interrupted and is repeated"] {
        assert!(transcript.contains(words), "no `{words}` in:\n{transcript}");
    }
    let log = fs::read_to_string(study.session().join("events.jsonl")).unwrap();
    let lost_events = log.lines().filter(|line| line.contains("\"not_saved\""));
    assert_eq!(lost_events.count(), 1);
    require_two(&study);
}

/// Fault 27.
#[test]
fn recordings_that_were_moved_are_asked_for_and_repeated_only_by_the_operators_word() {
    // The recordings were moved, and are moved back.
    let study = StudyCopy::new();
    cut_log_after(&study, 3);
    let (recording, moved) = (study.session().join(TRIAL), study.study().join("moved"));
    fs::rename(&recording, &moved).unwrap();
    let log = study.session().join("events.jsonl");
    let log_content = fs::read(&log).unwrap();
    let output = study.resume(&[]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    for words in [
        TRIAL,
        "its folder is missing",
        "put them back",
        "--repeat-lost",
    ] {
        let transcript = text(&output);
        assert!(transcript.contains(words), "no `{words}` in:\n{transcript}");
    }
    assert!(!text(&output).contains(SECOND), "{}", text(&output));
    assert_eq!(fs::read(&log).unwrap(), log_content);
    fs::rename(&moved, &recording).unwrap();
    let output = study.resume(&[]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(!text(&output).contains("is lost"), "{}", text(&output));
    require_two(&study);

    // The recordings are lost, because the recorder hung.
    let study = StudyCopy::new();
    cut_log_after(&study, 3);
    interrupt_recording(&study, TRIAL);
    interrupt_recording(&study, SECOND);
    let output = study.resume(&[]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    for trial in [TRIAL, SECOND] {
        assert!(text(&output).contains(trial), "{}", text(&output));
    }
    let output = study.resume(&["--repeat-lost"]);
    assert!(output.status.success(), "{}", text(&output));
    require_two(&study);
}
