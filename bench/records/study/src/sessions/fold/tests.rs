//! Tests of the attempts in a history.

use super::*;

fn start(time: &str) -> String {
    format!(
        r#"{{"document":"start","time":"{time}","resumed":false,"participant":"sub-01","session":1,"protocol":"p",
        "seed":1,"software":"s","version":"1","devices":{{}},"calibration":null,"configuration":null}}"#
    )
}

fn event(audio_s: f64, data: &str) -> String {
    format!(
        r#"{{"document":"event","stream":"session","seq_num":1,"time":"","audio_s":{audio_s},"data":{data}}}"#
    )
}

fn key(number: u32, attempt: u32) -> String {
    format!(
        r#"{{"number":{number},"attempt":{attempt},"practice":{},"condition":"c"}}"#,
        number == 1
    )
}

fn begin_line(audio_s: f64, key: &str) -> String {
    event(
        audio_s,
        &format!(r#"{{"event":"trial_began","key":{key}}}"#),
    )
}

fn settle_line(key: &str, outcome: &str) -> String {
    event(
        9.0,
        &format!(
            r#"{{"event":"trial_settled","record":{{"key":{key},"outcome":{outcome},"analysis":null}}}}"#
        ),
    )
}

fn session(lines: &[String]) -> LoggedSession {
    let content = LogContent {
        documents: lines
            .iter()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
        torn_lines: Vec::new(),
    };
    history(&content, logged_practice(&content))
}

#[test]
fn attempts_have_times_and_verdicts_with_reasons() {
    let (practice, first, second) = (key(1, 1), key(2, 1), key(2, 2));
    let reason = r#"{"outcome":"redo","reasons":[{"reason":"lost_samples","frames":3,"limit":0}]}"#;
    let lines = [
        start("2026-01-01T09:00:00Z"),
        begin_line(2.0, &practice),
        settle_line(&practice, r#"{"outcome":"accepted"}"#),
        begin_line(12.0, &first),
        settle_line(&first, reason),
        // Resumed a minute later, on a new audio clock.
        start("2026-01-01T09:01:00Z"),
        begin_line(3.0, &second),
    ];
    let session = session(&lines);
    let times: Vec<f64> = session
        .attempts
        .iter()
        .filter_map(|attempt| attempt.start_s)
        .collect();
    assert_eq!(times, [0.0, 10.0, 61.0]);
    assert_eq!(session.n_resumptions, 1);
    assert_eq!(session.end, SessionEnd::Unfinished);
    assert!(session.attempts[0].is_practice());
    assert_eq!(session.attempts[1].label.to_string(), "trial-001_attempt-1");
    let verdicts: Vec<_> = session.attempts.iter().map(Attempt::verdict).collect();
    assert_eq!(verdicts[0], ("accepted", Vec::new()));
    let reasons = vec!["3 lost frames, 0 allowed".to_owned()];
    assert_eq!(verdicts[1], ("repeated", reasons));
    assert_eq!(verdicts[2], ("not settled", Vec::new()));
}

#[test]
fn a_wall_clock_set_back_does_not_decrease_times() {
    let lines = [
        start("2026-01-01T09:00:00Z"),
        begin_line(5.0, &key(2, 1)),
        start("2025-12-31T09:00:00Z"),
        begin_line(8.0, &key(3, 1)),
    ];
    let times = |lines: &[String]| -> Vec<Option<f64>> {
        let attempts = session(lines).attempts;
        attempts.iter().map(|attempt| attempt.start_s).collect()
    };
    assert_eq!(times(&lines), [Some(0.0), Some(3.0)]);

    // Implausible times of an edited log.
    let edited_lines = [(1, -1e308), (2, 1e308), (3, 40.0 * 86_400.0)];
    let edited_lines = edited_lines.map(|(attempt, audio_s)| begin_line(audio_s, &key(3, attempt)));
    let lines = [&lines[..2], &edited_lines[..]].concat();
    assert_eq!(times(&lines), [Some(0.0), None, None, None]);
}

#[test]
fn a_log_without_a_start_gives_no_start() {
    assert_eq!(session(&[]), LoggedSession::default());
    let session = session(&[begin_line(5.0, &key(2, 1))]);
    assert_eq!((session.start, session.attempts.len()), (None, 1));
}
