//! A session as its log tells it, and what is out of order in it.

use std::collections::{BTreeMap, BTreeSet};

use protocols::{SessionEventKind, TrialKey, TrialOutcome};
use serde_json::Value;

use crate::defect::SessionDefect;
use crate::findings::{SessionEnd, Standing};
use recording::study::TrialLabel;
use recording::study::event_log::{Document, LogContent, LogEvent, Start};
use recording::sums::Sums;

/// An attempt as the log tells it.
#[derive(Debug, Clone, Default)]
pub struct Attempt {
    /// What became of it; `None` while it is open.
    pub standing: Option<Standing>,
    /// Whether it is called saved.
    pub saved: bool,
    /// The sums of its files.
    pub sums: Option<Sums>,
    /// Whether the log calls the recording broken off.
    pub interrupted: bool,
}

/// A session as its log tells it.
#[derive(Debug)]
pub struct SessionHistory {
    /// Attempts by label.
    pub attempts: BTreeMap<TrialLabel, Attempt>,
    /// Trials in the session's order, without practice.
    pub planned: Option<usize>,
    /// How it ended.
    pub end: SessionEnd,
    /// The last start.
    pub start: Option<Start>,
    /// What is out of order.
    pub defects: Vec<SessionDefect>,
}

/// State while the log is gone through.
struct Reading {
    history: SessionHistory,
    practice_trials: u32,
    running: bool,
    events: u64,
    audio_s: f64,
    streams: BTreeSet<String>,
    open: Option<TrialLabel>,
}

/// Returns the number of practice trials that the log's events show: the first other trial comes after them.
#[must_use]
pub fn practice_trials(content: &LogContent) -> u32 {
    let keys = content
        .documents
        .iter()
        .filter_map(|document| match document {
            Document::Event(event) => key(event),
            _ => None,
        });
    let numbers = keys.filter(|key| !key.practice).map(|key| key.number);
    numbers.min().unwrap_or(1).saturating_sub(1)
}

fn key(event: &LogEvent) -> Option<TrialKey> {
    match session_event(event)? {
        SessionEventKind::TrialBegan { key } => Some(key),
        SessionEventKind::TrialSettled { record } => Some(record.key),
        _ => None,
    }
}

fn session_event(event: &LogEvent) -> Option<SessionEventKind> {
    serde_json::from_value(Value::Object(event.data.clone())).ok()
}

impl SessionHistory {
    /// Goes through a log.
    #[must_use]
    pub fn of(content: &LogContent, practice_trials: u32) -> Self {
        let mut reading = Reading {
            history: Self {
                attempts: BTreeMap::new(),
                planned: None,
                end: SessionEnd::NotBegun,
                start: None,
                defects: Vec::new(),
            },
            practice_trials,
            running: false,
            events: 0,
            audio_s: f64::NEG_INFINITY,
            streams: BTreeSet::new(),
            open: None,
        };
        for (index, document) in content.documents.iter().enumerate() {
            reading.take(index + 1, document);
        }
        reading.history
    }
}

impl Reading {
    fn take(&mut self, number: usize, document: &Document) {
        let begins = matches!(document, Document::Start(_));
        if !begins && !self.running {
            self.defect(SessionDefect::NoStart { document: number });
            // Said once.
            self.running = true;
        }
        match document {
            Document::Start(start) => {
                self.running = true;
                self.audio_s = f64::NEG_INFINITY;
                self.open = None;
                self.history.start = Some((**start).clone());
                self.history.end = SessionEnd::Unfinished;
            }
            Document::Descriptor(descriptor) => {
                self.streams.insert(descriptor.stream.clone());
            }
            Document::Event(event) => self.event(event),
            Document::Stop(stop) => {
                self.running = false;
                if stop.num_events != self.events {
                    self.defect(SessionDefect::Count {
                        expected: stop.num_events,
                        found: self.events,
                    });
                }
                self.history.end = SessionEnd::Stopped {
                    status: stop.exit_status,
                    reason: stop.reason.clone(),
                };
            }
        }
    }

    fn defect(&mut self, defect: SessionDefect) {
        self.history.defects.push(defect);
    }

    fn event(&mut self, event: &LogEvent) {
        let number = event.seq_num;
        if number != self.events + 1 {
            self.defect(SessionDefect::Number {
                expected: self.events + 1,
                found: number,
            });
        }
        // One missing line is one defect.
        self.events = number;
        if event.audio_s < self.audio_s {
            self.defect(SessionDefect::Time {
                number,
                audio_s: event.audio_s,
                before_s: self.audio_s,
            });
        }
        self.audio_s = event.audio_s;
        if !self.streams.contains(&event.stream) {
            self.defect(SessionDefect::Undescribed {
                number,
                stream: event.stream.clone(),
            });
            self.streams.insert(event.stream.clone());
        }
        match session_event(event) {
            Some(SessionEventKind::SessionStarted { order, .. }) => {
                let practice = self.practice_trials as usize;
                self.history.planned = Some(order.len().saturating_sub(practice));
            }
            Some(SessionEventKind::TrialBegan { key }) => {
                let trial = TrialLabel::new(&key, self.practice_trials);
                if self.open.is_some() {
                    self.out_of_order(
                        number,
                        trial,
                        "began before the trial before it was settled",
                    );
                }
                if self.history.attempts.contains_key(&trial) {
                    self.out_of_order(number, trial, "began twice");
                }
                self.history.attempts.entry(trial).or_default();
                self.open = Some(trial);
            }
            Some(SessionEventKind::TrialSettled { record }) => {
                let trial = TrialLabel::new(&record.key, self.practice_trials);
                if self.open.take() != Some(trial) {
                    self.out_of_order(number, trial, "was settled and had not begun");
                }
                self.attempt(trial).standing = Some(match record.outcome {
                    TrialOutcome::Accepted | TrialOutcome::AcceptedAnyway { .. } => {
                        Standing::Accepted
                    }
                    TrialOutcome::Redo { .. } => Standing::Repeated,
                    TrialOutcome::GivenUp { .. } => Standing::GivenUp,
                    TrialOutcome::Interrupted { .. } => Standing::Interrupted,
                });
            }
            _ => self.saved(event),
        }
    }

    fn saved(&mut self, event: &LogEvent) {
        let name = event.data.get("saved").and_then(Value::as_str);
        let Some(trial) = name.and_then(|name| name.parse::<TrialLabel>().ok()) else {
            return;
        };
        if !self.history.attempts.contains_key(&trial) {
            self.out_of_order(event.seq_num, trial, "was saved and had not begun");
        }
        let sums = event.data.get("sha256").cloned();
        let interrupted = event.data.get("interrupted").and_then(Value::as_bool);
        let attempt = self.attempt(trial);
        attempt.saved = true;
        attempt.interrupted = interrupted.unwrap_or(false);
        attempt.sums = sums.and_then(|sums| serde_json::from_value(sums).ok());
    }

    fn attempt(&mut self, trial: TrialLabel) -> &mut Attempt {
        self.history.attempts.entry(trial).or_default()
    }

    fn out_of_order(&mut self, number: u64, trial: TrialLabel, what: &'static str) {
        self.defect(SessionDefect::Order {
            number,
            trial,
            what,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines of a log, with these in place of the events of its one trial.
    fn history(events: &[&str]) -> SessionHistory {
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
        SessionHistory::of(&content, practice_trials(&content))
    }

    fn event(number: u64, audio_s: f64, data: &str) -> String {
        format!(
            r#"{{"document":"event","stream":"session","seq_num":{number},"time":"","audio_s":{audio_s},"data":{data}}}"#
        )
    }

    /// The key of a trial after one of practice.
    fn key(trial: u32) -> String {
        let number = trial + 1;
        format!(r#"{{"number":{number},"attempt":1,"practice":false,"condition":"c"}}"#)
    }

    fn began(number: u64, trial: u32) -> String {
        let data = format!(r#"{{"event":"trial_began","key":{}}}"#, key(trial));
        event(number, number as f64, &data)
    }

    fn settled(number: u64, trial: u32) -> String {
        let data = format!(
            r#"{{"event":"trial_settled","record":{{"key":{},"outcome":{{"outcome":"accepted"}},"analysis":null}}}}"#,
            key(trial)
        );
        event(number, number as f64, &data)
    }

    fn saved(number: u64, name: &str) -> String {
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
    fn a_trial_that_began_was_saved_and_settled_is_in_order() {
        let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":3}"#;
        let found = history(&[&began(1, 1), &saved(2, FIRST), &settled(3, 1), stop]);
        assert_eq!(found.defects, []);
        let attempt = &found.attempts[&label(FIRST)];
        assert_eq!(attempt.standing, Some(Standing::Accepted));
        assert!(attempt.saved);
        assert_eq!(attempt.sums.as_ref().unwrap()["force.csv"], "ab");
        assert!(matches!(found.end, SessionEnd::Stopped { .. }));
        assert!(!attempt.interrupted);
    }

    #[test]
    fn a_trial_that_the_programs_end_broke_off_is_saved_and_interrupted() {
        let saved = saved(2, FIRST).replace(r#""sha256""#, r#""interrupted":true,"sha256""#);
        let stop = r#"{"document":"stop","time":"","exit_status":"abort","num_events":2}"#;
        let found = history(&[&began(1, 1), &saved, stop]);
        assert_eq!(found.defects, []);
        let attempt = &found.attempts[&label(FIRST)];
        assert_eq!(attempt.standing, None);
        assert!(attempt.saved && attempt.interrupted && attempt.sums.is_some());
    }

    #[test]
    fn each_disorder_is_one_defect() {
        let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":2}"#;
        let early = event(2, 0.5, "{}");
        let other = event(2, 2.0, "{}").replace("\"session\"", "\"other\"");
        let defects = |events: &[&str]| history(events).defects;
        let order = |found: &[SessionDefect]| matches!(found, [SessionDefect::Order { .. }]);
        let first = began(1, 1);
        assert!(matches!(
            defects(&[&first, &settled(3, 1)])[..],
            [SessionDefect::Number {
                expected: 2,
                found: 3
            }]
        ));
        assert!(matches!(
            defects(&[&first, &early])[..],
            [SessionDefect::Time { number: 2, .. }]
        ));
        assert!(matches!(
            defects(&[&first, &other])[..],
            [SessionDefect::Undescribed { number: 2, .. }]
        ));
        assert!(matches!(
            defects(&[&first, stop])[..],
            [SessionDefect::Count {
                expected: 2,
                found: 1
            }]
        ));
        assert!(matches!(
            defects(&[stop.replace('2', "0").as_str(), &first])[..],
            [SessionDefect::NoStart { document: 4 }]
        ));
        assert!(order(&defects(&[&first, &began(2, 2)])));
        assert!(order(&defects(&[&first, &settled(2, 1), &began(3, 1)])));
        assert!(order(&defects(&[&first, &settled(2, 2)])));
        assert!(order(&defects(&[&saved(1, FIRST)])));
    }
}
