//! A session as its log tells it.

use jiff::Timestamp;
use protocols::{SessionEventKind, TrialKey, TrialOutcome};
use recording::study::event_log::{Document, ExitStatus, LogContent, LogEvent, Start};
use recording::study::{TrialBlock, TrialLabel};
use serde_json::Value;

/// Longest time between two recordings of a session, resumed ones included, s: a month.
const LONGEST_S: f64 = 31.0 * 86_400.0;

/// Session as its log tells it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Session {
    /// Its first start; `None` of a log that has none.
    pub start: Option<Start>,
    /// Number of times that it was resumed.
    pub resumed: usize,
    /// How it ended.
    pub end: SessionEnd,
    /// Attempts at trials, in the order in which they began.
    pub attempts: Vec<Attempt>,
}

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum SessionEnd {
    /// The program was killed, or the session still goes on.
    #[default]
    Unfinished,
    /// As its log says, with the reason unless all trials are done.
    Stopped(ExitStatus, Option<String>),
}

/// Attempt at a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// The attempt, which names its recording's folder.
    pub label: TrialLabel,
    /// Name of the condition.
    pub condition: String,
    /// Start of its recording, s after that of the session's first one; `None` where the log has no plausible time.
    pub start_s: Option<f64>,
    /// How it was settled; `None` where the log breaks off before.
    pub outcome: Option<TrialOutcome>,
}

impl Attempt {
    /// Returns the verdict in a word, and the reasons for it, of which there may be none.
    #[must_use]
    pub fn verdict(&self) -> (&'static str, Vec<String>) {
        let all = |reasons: &[protocols::RedoReason]| -> Vec<String> {
            reasons.iter().map(ToString::to_string).collect()
        };
        match &self.outcome {
            None => ("not settled", Vec::new()),
            Some(TrialOutcome::Accepted) => ("accepted", Vec::new()),
            Some(TrialOutcome::AcceptedAnyway { reasons }) => ("accepted anyway", all(reasons)),
            Some(TrialOutcome::Redo { reasons }) if reasons.is_empty() => {
                ("repeated", vec!["as the operator asked".to_owned()])
            }
            Some(TrialOutcome::Redo { reasons }) => ("repeated", all(reasons)),
            Some(TrialOutcome::GivenUp { reasons }) => ("given up", all(reasons)),
            Some(TrialOutcome::Interrupted { interruption }) => {
                ("interrupted", vec![interruption.to_string()])
            }
        }
    }

    /// Returns whether it is a practice trial.
    #[must_use]
    pub fn is_practice(&self) -> bool {
        self.label.block == TrialBlock::Practice
    }
}

impl Session {
    /// Goes through a log.
    #[must_use]
    pub fn of(content: &LogContent) -> Self {
        let practice = practice_trials(content);
        let mut session = Self::default();
        let mut first: Option<Timestamp> = None;
        // Of the present part of the session, whose audio clock begins with it.
        let mut part_s = 0.0;
        for document in &content.documents {
            match document {
                Document::Start(start) => {
                    session.end = SessionEnd::Unfinished;
                    let time: Option<Timestamp> = start.time.parse().ok();
                    first = first.or(time);
                    let since = first
                        .zip(time)
                        .map(|(first, time)| time.duration_since(first));
                    // The wall clock may be set back; time does not.
                    part_s = since
                        .map_or(part_s, |since| since.as_secs_f64())
                        .max(part_s);
                    match &session.start {
                        None => session.start = Some((**start).clone()),
                        Some(_) => session.resumed += 1,
                    }
                }
                Document::Event(event) => session.take(event, part_s, practice),
                Document::Stop(stop) => {
                    session.end = SessionEnd::Stopped(stop.exit_status, stop.reason.clone());
                }
                Document::Descriptor(_) => {}
            }
        }
        let origin_s = session.attempts.first().and_then(|first| first.start_s);
        for attempt in &mut session.attempts {
            let since = attempt
                .start_s
                .zip(origin_s)
                .map(|(start_s, origin_s)| start_s - origin_s);
            attempt.start_s = since.filter(|since| (0.0..=LONGEST_S).contains(since));
        }
        session
    }

    fn take(&mut self, event: &LogEvent, part_s: f64, practice: u32) {
        match session_event(event) {
            Some(SessionEventKind::TrialBegan { key }) => self.attempts.push(Attempt {
                label: TrialLabel::new(&key, practice),
                condition: key.condition,
                start_s: Some(part_s + event.audio_s),
                outcome: None,
            }),
            Some(SessionEventKind::TrialSettled { record }) => {
                let label = TrialLabel::new(&record.key, practice);
                let mut attempts = self.attempts.iter_mut();
                if let Some(attempt) = attempts.find(|attempt| attempt.label == label) {
                    attempt.outcome = Some(record.outcome);
                }
            }
            _ => {}
        }
    }
}

/// Returns the number of practice trials: the first other trial comes after them.
fn practice_trials(content: &LogContent) -> u32 {
    let events = content
        .documents
        .iter()
        .filter_map(|document| match document {
            Document::Event(event) => session_event(event),
            _ => None,
        });
    let keys = events.filter_map(|event| match event {
        SessionEventKind::TrialBegan { key } => Some(key),
        SessionEventKind::TrialSettled { record } => Some(record.key),
        _ => None,
    });
    let others = keys.filter(|key: &TrialKey| !key.practice);
    others
        .map(|key| key.number)
        .min()
        .unwrap_or(1)
        .saturating_sub(1)
}

fn session_event(event: &LogEvent) -> Option<SessionEventKind> {
    serde_json::from_value(Value::Object(event.data.clone())).ok()
}

#[cfg(test)]
mod tests {
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

    fn began(audio_s: f64, key: &str) -> String {
        event(
            audio_s,
            &format!(r#"{{"event":"trial_began","key":{key}}}"#),
        )
    }

    fn settled(key: &str, outcome: &str) -> String {
        event(
            9.0,
            &format!(
                r#"{{"event":"trial_settled","record":{{"key":{key},"outcome":{outcome},"analysis":null}}}}"#
            ),
        )
    }

    fn session(lines: &[String]) -> Session {
        Session::of(&LogContent {
            documents: lines
                .iter()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect(),
            torn_lines: Vec::new(),
        })
    }

    #[test]
    fn attempts_have_their_time_since_the_first_and_their_verdict_with_its_reasons() {
        let (practice, first, again) = (key(1, 1), key(2, 1), key(2, 2));
        let reason =
            r#"{"outcome":"redo","reasons":[{"reason":"lost_samples","frames":3,"limit":0}]}"#;
        let lines = [
            start("2026-01-01T09:00:00Z"),
            began(2.0, &practice),
            settled(&practice, r#"{"outcome":"accepted"}"#),
            began(12.0, &first),
            settled(&first, reason),
            // Resumed a minute later, on a new audio clock.
            start("2026-01-01T09:01:00Z"),
            began(3.0, &again),
        ];
        let found = session(&lines);
        let times: Vec<f64> = found.attempts.iter().filter_map(|of| of.start_s).collect();
        assert_eq!(times, [0.0, 10.0, 61.0]);
        assert_eq!(found.resumed, 1);
        assert_eq!(found.end, SessionEnd::Unfinished);
        assert!(found.attempts[0].is_practice());
        assert_eq!(found.attempts[1].label.to_string(), "trial-001_attempt-1");
        let verdicts: Vec<_> = found.attempts.iter().map(Attempt::verdict).collect();
        assert_eq!(verdicts[0], ("accepted", Vec::new()));
        let lost = vec!["3 lost frames, 0 allowed".to_owned()];
        assert_eq!(verdicts[1], ("repeated", lost));
        assert_eq!(verdicts[2], ("not settled", Vec::new()));
    }

    #[test]
    fn a_wall_clock_that_was_set_back_turns_no_time_back() {
        let lines = [
            start("2026-01-01T09:00:00Z"),
            began(5.0, &key(2, 1)),
            start("2025-12-31T09:00:00Z"),
            began(8.0, &key(3, 1)),
        ];
        let times = |lines: &[String]| -> Vec<Option<f64>> {
            let attempts = session(lines).attempts;
            attempts.iter().map(|of| of.start_s).collect()
        };
        assert_eq!(times(&lines), [Some(0.0), Some(3.0)]);

        // Times that are none, of a log that was edited.
        let edited = [-1e308, 1e308, 40.0 * 86_400.0].map(|audio_s| began(audio_s, &key(3, 1)));
        let lines = [&lines[..2], &edited[..]].concat();
        assert_eq!(times(&lines), [Some(0.0), None, None, None]);
    }

    #[test]
    fn a_log_without_a_start_or_with_nothing_tells_nothing() {
        assert_eq!(session(&[]), Session::default());
        let lone = session(&[began(5.0, &key(2, 1))]);
        assert_eq!((lone.start, lone.attempts.len()), (None, 1));
    }
}
