//! History of a session by its log.

use std::collections::BTreeMap;

use jiff::Timestamp;
use protocols::{Interval, SessionEventKind, TrialKey, TrialOutcome};
use recording::study::event_log::{Document, ExitStatus, LogContent, LogEvent, Start};
use recording::study::{TrialBlock, TrialLabel};
use recording::sums::Sums;
use serde_json::Value;

use crate::sessions::standing::Standing;

/// Longest time between two recordings of a session, resumed ones included, s: a month.
const LONGEST_S: f64 = 31.0 * 86_400.0;

/// History of a session by its log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoggedSession {
    /// First start; `None` if it is missing.
    pub start: Option<Start>,
    /// Number of resumptions.
    pub n_resumptions: usize,
    /// End of the session.
    pub end: SessionEnd,
    /// Planned trials, without practice; `None` if the log does not say.
    pub planned: Option<usize>,
    /// Attempts at trials, in the order of their starts.
    pub attempts: Vec<Attempt>,
}

/// End of a session.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum SessionEnd {
    /// The program was killed, or the session is still running.
    #[default]
    Unfinished,
    /// The session ended as its log says, with the reason unless all trials are done.
    Stopped(ExitStatus, Option<String>),
}

/// Attempt at a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// Label of the attempt, which names its recording's folder.
    pub label: TrialLabel,
    /// Name of the condition.
    pub condition: String,
    /// Start of its recording relative to the session's first recording, s; `None` where the log has no plausible time.
    pub start_s: Option<f64>,
    /// Outcome; `None` where the log ends before it.
    pub outcome: Option<TrialOutcome>,
    /// Part of the session in which it was made, from 1; each resumption begins another.
    pub part: usize,
    /// Intervals marked in its recording.
    pub intervals: Vec<Interval>,
    /// Whether the log calls its recording saved.
    pub is_saved: bool,
    /// Whether the log calls its recording interrupted.
    pub is_interrupted: bool,
    /// Sums of its recording's files.
    pub sums: Option<Sums>,
}

impl Attempt {
    fn new(label: TrialLabel, condition: String, part: usize) -> Self {
        Self {
            label,
            condition,
            start_s: None,
            outcome: None,
            part,
            intervals: Vec::new(),
            is_saved: false,
            is_interrupted: false,
            sums: None,
        }
    }

    /// Returns the standing of the attempt; an attempt that the log leaves open was interrupted.
    #[must_use]
    pub fn standing(&self) -> Standing {
        self.outcome
            .as_ref()
            .map_or(Standing::Interrupted, Standing::from_outcome)
    }

    /// Returns the verdict in a word, and its reasons, if there are any.
    #[must_use]
    pub fn verdict(&self) -> (&'static str, Vec<String>) {
        let texts = |reasons: &[protocols::RedoReason]| -> Vec<String> {
            reasons.iter().map(ToString::to_string).collect()
        };
        match &self.outcome {
            None => ("not settled", Vec::new()),
            Some(TrialOutcome::Accepted) => ("accepted", Vec::new()),
            Some(TrialOutcome::AcceptedAnyway { reasons }) => ("accepted anyway", texts(reasons)),
            Some(TrialOutcome::Redo { reasons }) if reasons.is_empty() => {
                ("repeated", vec!["as the operator asked".to_owned()])
            }
            Some(TrialOutcome::Redo { reasons }) => ("repeated", texts(reasons)),
            Some(TrialOutcome::GivenUp { reasons }) => ("given up", texts(reasons)),
            Some(TrialOutcome::Interrupted { interruption }) => {
                ("interrupted", vec![interruption.to_string()])
            }
        }
    }

    /// Returns whether the attempt is at a practice trial.
    #[must_use]
    pub fn is_practice(&self) -> bool {
        self.label.block == TrialBlock::Practice
    }
}

impl LoggedSession {
    /// Reads the history from a log.
    #[must_use]
    pub fn from_log(content: &LogContent) -> Self {
        Self::after_practice(content, practice_trials(content))
    }

    /// Reads the history from the log of a session that begins with `practice` practice trials.
    #[must_use]
    pub fn after_practice(content: &LogContent, practice: u32) -> Self {
        let mut reading = Reading {
            session: Self::default(),
            practice,
            part: 0,
            part_s: 0.0,
            open_trial: None,
        };
        let mut first_time: Option<Timestamp> = None;
        for document in &content.documents {
            match document {
                Document::Start(start) => {
                    let time: Option<Timestamp> = start.time.parse().ok();
                    first_time = first_time.or(time);
                    let offset = first_time
                        .zip(time)
                        .map(|(first_time, time)| time.duration_since(first_time));
                    reading.start(start, offset.map(|offset| offset.as_secs_f64()));
                }
                Document::Event(event) => reading.event(event),
                Document::Stop(stop) => {
                    reading.session.end =
                        SessionEnd::Stopped(stop.exit_status, stop.reason.clone());
                }
                Document::Descriptor(_) => {}
            }
        }
        let mut session = reading.session;
        let origin_s = session.attempts.first().and_then(|first| first.start_s);
        for attempt in &mut session.attempts {
            let offset_s = attempt
                .start_s
                .zip(origin_s)
                .map(|(start_s, origin_s)| start_s - origin_s);
            attempt.start_s = offset_s.filter(|offset_s| (0.0..=LONGEST_S).contains(offset_s));
        }
        session
    }

    /// Returns the accepted attempts, one for each trial: the last, if there are several.
    #[must_use]
    pub fn accepted(&self) -> Vec<&Attempt> {
        let mut accepted = BTreeMap::new();
        for attempt in &self.attempts {
            if attempt.standing() == Standing::Accepted {
                accepted.insert((attempt.label.block, attempt.label.number), attempt);
            }
        }
        accepted.into_values().collect()
    }
}

/// State while reading a log.
struct Reading {
    session: LoggedSession,
    practice: u32,
    /// Current part of the session, from 1.
    part: usize,
    /// Start of that part, when its audio clock begins, s after the session's first start.
    part_s: f64,
    /// Attempt in progress.
    open_trial: Option<TrialLabel>,
}

impl Reading {
    fn start(&mut self, start: &Start, since_s: Option<f64>) {
        self.part += 1;
        self.open_trial = None;
        // The wall clock may be set back.
        self.part_s = since_s.unwrap_or(self.part_s).max(self.part_s);
        self.session.end = SessionEnd::Unfinished;
        match &self.session.start {
            None => self.session.start = Some(start.clone()),
            Some(_) => self.session.n_resumptions += 1,
        }
    }

    fn event(&mut self, event: &LogEvent) {
        match session_event(event) {
            Some(SessionEventKind::SessionStarted { order, .. }) => {
                let practice = self.practice as usize;
                self.session.planned = Some(order.len().saturating_sub(practice));
            }
            Some(SessionEventKind::TrialBegan { key }) => {
                let start_s = self.part_s + event.audio_s;
                let label = TrialLabel::new(&key, self.practice);
                self.open_trial = Some(label);
                self.attempt(label, &key.condition).start_s = Some(start_s);
            }
            Some(SessionEventKind::Marked { interval }) => {
                if let Some(label) = self.open_trial {
                    self.attempt(label, "").intervals.push(interval);
                }
            }
            Some(SessionEventKind::TrialSettled { record }) => {
                let label = TrialLabel::new(&record.key, self.practice);
                self.open_trial = None;
                self.attempt(label, &record.key.condition).outcome = Some(record.outcome);
            }
            _ => self.read_saved(event),
        }
    }

    fn read_saved(&mut self, event: &LogEvent) {
        let name = event.data.get("saved").and_then(Value::as_str);
        let Some(label) = name.and_then(|name| name.parse().ok()) else {
            return;
        };
        let sums = event.data.get("sha256").cloned();
        let is_interrupted = event.data.get("interrupted").and_then(Value::as_bool);
        let attempt = self.attempt(label, "");
        attempt.is_saved = true;
        attempt.is_interrupted = is_interrupted.unwrap_or(false);
        attempt.sums = sums.and_then(|sums| serde_json::from_value(sums).ok());
    }

    fn attempt(&mut self, label: TrialLabel, condition: &str) -> &mut Attempt {
        let attempts = &mut self.session.attempts;
        let index = attempts.iter().position(|attempt| attempt.label == label);
        let index = index.unwrap_or_else(|| {
            attempts.push(Attempt::new(label, condition.to_owned(), self.part));
            attempts.len() - 1
        });
        &mut attempts[index]
    }
}

/// Returns the number of practice trials by the log's events: the number of the first other trial, less one.
#[must_use]
pub fn practice_trials(content: &LogContent) -> u32 {
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
    let main_keys = keys.filter(|key: &TrialKey| !key.practice);
    main_keys
        .map(|key| key.number)
        .min()
        .unwrap_or(1)
        .saturating_sub(1)
}

/// Parses an event of the log as one of the protocol's state machine; `None` if it is another kind of event.
#[must_use]
pub fn session_event(event: &LogEvent) -> Option<SessionEventKind> {
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
        LoggedSession::from_log(&LogContent {
            documents: lines
                .iter()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect(),
            torn_lines: Vec::new(),
        })
    }

    #[test]
    fn attempts_have_times_and_verdicts_with_reasons() {
        let (practice, first, second) = (key(1, 1), key(2, 1), key(2, 2));
        let reason =
            r#"{"outcome":"redo","reasons":[{"reason":"lost_samples","frames":3,"limit":0}]}"#;
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
        let edited_lines =
            edited_lines.map(|(attempt, audio_s)| begin_line(audio_s, &key(3, attempt)));
        let lines = [&lines[..2], &edited_lines[..]].concat();
        assert_eq!(times(&lines), [Some(0.0), None, None, None]);
    }

    #[test]
    fn a_log_without_a_start_gives_no_start() {
        assert_eq!(session(&[]), LoggedSession::default());
        let session = session(&[begin_line(5.0, &key(2, 1))]);
        assert_eq!((session.start, session.attempts.len()), (None, 1));
    }
}
