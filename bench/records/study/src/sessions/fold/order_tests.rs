//! Tests of the order of a log.

use super::*;
use crate::sessions::standing::Standing;

/// Returns the history by a log of one trial with `events` as the trial's events.
fn log_history(events: &[&str]) -> LoggedSession {
    let start = r#"{"document":"start","time":"","resumed":false,"participant":"sub-01","session":1,"protocol":"p",
        "seed":1,"software":"s","version":"1","devices":{},"calibration":null,"configuration":null}"#;
    let descriptor = r#"{"document":"descriptor","stream":"session","data_keys":{}}"#;
    let lines = [start, descriptor]
        .into_iter()
        .chain(events.iter().copied());
    let content = LogContent {
        documents: lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
        torn_lines: Vec::new(),
    };
    history(&content, logged_practice(&content))
}

fn event(number: u64, audio_s: f64, data: &str) -> String {
    format!(
        r#"{{"document":"event","stream":"session","seq_num":{number},"time":"","audio_s":{audio_s},"data":{data}}}"#
    )
}

/// Returns the key of a trial that follows one practice trial.
fn key(trial: u32) -> String {
    let number = trial + 1;
    format!(r#"{{"number":{number},"attempt":1,"practice":false,"condition":"c"}}"#)
}

fn begin_line(number: u64, trial: u32) -> String {
    let data = format!(r#"{{"event":"trial_began","key":{}}}"#, key(trial));
    event(number, number as f64, &data)
}

fn settle_line(number: u64, trial: u32) -> String {
    let data = format!(
        r#"{{"event":"trial_settled","record":{{"key":{},"outcome":{{"outcome":"accepted"}},"analysis":null}}}}"#,
        key(trial)
    );
    event(number, number as f64, &data)
}

fn save_line(number: u64, name: &str) -> String {
    event(
        number,
        number as f64,
        &format!(r#"{{"saved":"{name}","sha256":{{"force.csv":"ab"}}}}"#),
    )
}

fn label(name: &str) -> TrialLabel {
    name.parse().unwrap()
}

const FIRST: &str = "trial-001_attempt-1";

#[test]
fn a_complete_trial_is_in_order() {
    let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":3}"#;
    let history = log_history(&[
        &begin_line(1, 1),
        &save_line(2, FIRST),
        &settle_line(3, 1),
        stop,
    ]);
    assert_eq!(history.defects, []);
    let attempt = history.attempt(label(FIRST)).unwrap();
    assert_eq!(attempt.standing(), Standing::Accepted);
    assert!(attempt.is_saved);
    assert_eq!(attempt.sums.as_ref().unwrap()["force.csv"], "ab");
    assert!(matches!(history.end, SessionEnd::Stopped { .. }));
    assert!(!attempt.is_interrupted);
}

#[test]
fn a_trial_interrupted_by_the_programs_end_is_saved() {
    let save_line = save_line(2, FIRST).replace(r#""sha256""#, r#""interrupted":true,"sha256""#);
    let stop = r#"{"document":"stop","time":"","exit_status":"abort","num_events":2}"#;
    let history = log_history(&[&begin_line(1, 1), &save_line, stop]);
    assert_eq!(history.defects, []);
    let attempt = history.attempt(label(FIRST)).unwrap();
    assert_eq!(attempt.outcome, None);
    assert!(attempt.is_saved && attempt.is_interrupted && attempt.sums.is_some());
}

#[test]
fn each_disorder_is_one_defect() {
    let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":2}"#;
    let early_event = event(2, 0.5, "{}");
    let other_stream_event = event(2, 2.0, "{}").replace("\"session\"", "\"other\"");
    let defects = |events: &[&str]| log_history(events).defects;
    let is_order = |defects: &[LogDefect]| matches!(defects, [LogDefect::Order { .. }]);
    let first = begin_line(1, 1);
    assert!(matches!(
        defects(&[&first, &settle_line(3, 1)])[..],
        [LogDefect::Number {
            expected: 2,
            found: 3
        }]
    ));
    assert!(matches!(
        defects(&[&first, &early_event])[..],
        [LogDefect::Time { number: 2, .. }]
    ));
    assert!(matches!(
        defects(&[&first, &other_stream_event])[..],
        [LogDefect::Undescribed { number: 2, .. }]
    ));
    assert!(matches!(
        defects(&[&first, stop])[..],
        [LogDefect::Count {
            expected: 2,
            found: 1
        }]
    ));
    assert!(matches!(
        defects(&[stop.replace('2', "0").as_str(), &first])[..],
        [LogDefect::NoStart { document: 4 }]
    ));
    assert!(is_order(&defects(&[&first, &begin_line(2, 2)])));
    assert!(is_order(&defects(&[
        &first,
        &settle_line(2, 1),
        &begin_line(3, 1)
    ])));
    assert!(is_order(&defects(&[&first, &settle_line(2, 2)])));
    assert!(is_order(&defects(&[&save_line(1, FIRST)])));
}

/// Lines of a log by an early version, in which the window read the audio clock separately.
///
/// Fault 27.
#[test]
fn a_late_event_of_the_window_in_an_old_log_is_no_alarm() {
    let descriptor = r#"{"document":"descriptor","stream":"display","data_keys":{}}"#;
    let display_line = |number, audio_s, stream: &str| {
        let data = r#"{"event":"exploration_shown","start_s":19.8,"frames":102}"#;
        event(number, audio_s, data).replace("\"session\"", &format!("\"{stream}\""))
    };
    let lift_line = |number, audio_s| event(number, audio_s, r#"{"event":"phase","phase":"lift"}"#);
    let time_defects = |events: &[String]| {
        let events = events.iter().map(String::as_str);
        let lines: Vec<_> = std::iter::once(descriptor).chain(events).collect();
        log_history(&lines).defects
    };
    let old_log = [
        lift_line(1, 21.533),
        display_line(2, 21.531, "display"),
        lift_line(3, 21.535),
    ];
    assert_eq!(time_defects(&old_log), []);
    assert_eq!(
        time_defects(&[lift_line(1, 21.533), display_line(2, 21.523, "display")]),
        []
    );
    let assert_alarm = |events: &[String], event_number: u64| match time_defects(events)[..] {
        [LogDefect::Time { number, .. }] => assert_eq!(number, event_number),
        ref other => panic!("{other:?}"),
    };
    assert_alarm(
        &[lift_line(1, 21.533), display_line(2, 21.522, "display")],
        2,
    );
    assert_alarm(
        &[lift_line(1, 21.533), display_line(2, 21.531, "session")],
        2,
    );
    let late_log = [
        lift_line(1, 21.533),
        display_line(2, 21.525, "display"),
        lift_line(3, 21.530),
    ];
    assert_alarm(&late_log, 3);
}

/// A resumed session revokes the acceptance of a trial with a missing recording.
///
/// Fault 27.
#[test]
fn a_later_part_takes_back_that_a_trial_was_accepted() {
    let start = r#"{"document":"start","time":"","resumed":true,"participant":"sub-01","session":1,"protocol":"p",
        "seed":1,"software":"s","version":"1","devices":{},"calibration":null,"configuration":null}"#;
    let loss_line = |number| {
        let outcome = r#"{"outcome":"interrupted","interruption":"not_saved","reason":"lost"}"#;
        settle_line(number, 1).replace(r#"{"outcome":"accepted"}"#, outcome)
    };
    let accepted_lines = [begin_line(1, 1), save_line(2, FIRST), settle_line(3, 1)];
    let log = |later_lines: &[&str]| {
        let lines = accepted_lines
            .iter()
            .map(String::as_str)
            .chain(later_lines.iter().copied());
        log_history(&lines.collect::<Vec<_>>())
    };
    let history = log(&[start, &loss_line(4)]);
    assert_eq!(history.defects, []);
    let attempt = history.attempt(label(FIRST)).unwrap();
    assert_eq!(attempt.standing(), Standing::Interrupted);
    let is_order =
        |history: LoggedSession| matches!(history.defects[..], [LogDefect::Order { .. }]);
    assert!(
        is_order(log(&[start, &loss_line(4), &loss_line(5)])),
        "once"
    );
    assert!(
        is_order(log(&[start, &begin_line(4, 2), &loss_line(5)])),
        "amid a trial"
    );
    assert!(
        is_order(log(&[start, &settle_line(4, 1)])),
        "to nothing else"
    );
}

/// The log continues as after a saved recording, but never calls it saved.
///
/// Fault 27.
#[test]
fn an_accepted_trial_should_be_saved_if_a_later_one_is() {
    let is_unsaved = |events: &[&str]| {
        let history = log_history(events);
        history.should_be_saved(history.attempt(label(FIRST)).unwrap())
    };
    let (begin, accept) = (begin_line(1, 1), settle_line(2, 1));
    assert!(!is_unsaved(&[&begin, &accept]), "the program was killed");
    let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":2}"#;
    assert!(!is_unsaved(&[&begin, &accept, stop]), "a log without any");
    let later_lines = [
        begin_line(3, 2),
        save_line(4, "trial-002_attempt-1"),
        settle_line(5, 2),
    ];
    let events = [
        &begin,
        &accept,
        &later_lines[0],
        &later_lines[1],
        &later_lines[2],
    ]
    .map(String::as_str);
    assert!(is_unsaved(&events));
}

#[test]
fn a_stop_that_calls_the_session_complete_counts_its_trials() {
    let start_event = event(
        1,
        0.0,
        r#"{"event":"session_started","participant":"sub-01","protocol":"p","seed":1,"order":["c","c","c"],
            "resumed_attempts":0}"#,
    );
    let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":3}"#;
    let complete = log_history(&[&start_event, &begin_line(2, 1), &settle_line(3, 1), stop]);
    assert_eq!(
        complete.defects,
        [LogDefect::NotAllSettled {
            planned: 2,
            settled: 1
        }]
    );
    let stop = stop.replace("success", "abort");
    let aborted = log_history(&[&start_event, &begin_line(2, 1), &settle_line(3, 1), &stop]);
    assert_eq!(aborted.defects, []);
}
