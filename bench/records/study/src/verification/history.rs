//! History of a session by its log, and defects in the order of its events.

use std::collections::{BTreeMap, BTreeSet};

use crate::sessions::{Attempt, LoggedSession, session_event};
use protocols::{Interruption, SessionEventKind, TrialOutcome, TrialRecord};
use serde_json::Value;

use crate::verification::defect::SessionDefect;
use crate::verification::findings::SessionEndFinding;
use recording::study::event_log::{Document, ExitStatus, LogContent, LogEvent, Start};
use recording::study::{TrialBlock, TrialLabel};

/// Stream of the participant window.
const DISPLAY_STREAM: &str = "display";
/// Longest delay of an event of the window, s. In early versions the window read the audio clock separately, up to
/// one period of the session earlier than the session did; the log's own clock is the same.
const LATE_DISPLAY_S: f64 = 0.010;
/// Rounding error of a difference between two times of a log, s.
const ROUNDING_S: f64 = 1e-9;

/// History of a session by its log.
#[derive(Debug)]
pub struct SessionHistory {
    /// Attempts by label.
    pub attempts: BTreeMap<TrialLabel, Attempt>,
    /// Trials planned for the session, without practice.
    pub planned: Option<usize>,
    /// End of the session.
    pub end: SessionEndFinding,
    /// Last start.
    pub start: Option<Start>,
    /// Events out of order.
    pub defects: Vec<SessionDefect>,
    /// Parts of the session with a stop after the last attempt, which shows that everything was written.
    stopped_parts: BTreeSet<usize>,
}

/// State while reading the log.
struct Reading {
    history: SessionHistory,
    practice_trials: u32,
    is_running: bool,
    part: usize,
    n_events: u64,
    audio_s: f64,
    streams: BTreeSet<String>,
    begun_trials: BTreeSet<TrialLabel>,
    /// Trials settled by an attempt; a later part of the session may revoke this.
    settled_trials: BTreeSet<TrialLabel>,
    open_trial: Option<TrialLabel>,
}

impl SessionHistory {
    /// Reads the history from a log.
    #[must_use]
    pub fn from_log(content: &LogContent, practice_trials: u32) -> Self {
        let session = LoggedSession::after_practice(content, practice_trials);
        let attempts = session.attempts.into_iter();
        let mut reading = Reading {
            history: Self {
                attempts: attempts.map(|attempt| (attempt.label, attempt)).collect(),
                planned: session.planned,
                end: SessionEndFinding::NotBegun,
                start: None,
                defects: Vec::new(),
                stopped_parts: BTreeSet::new(),
            },
            practice_trials,
            is_running: false,
            part: 0,
            n_events: 0,
            audio_s: f64::NEG_INFINITY,
            streams: BTreeSet::new(),
            begun_trials: BTreeSet::new(),
            settled_trials: BTreeSet::new(),
            open_trial: None,
        };
        for (index, document) in content.documents.iter().enumerate() {
            reading.read(index + 1, document);
        }
        reading.history.require_all_settled();
        reading.history
    }

    /// Returns whether the log should call an attempt saved: it does so for other attempts of that time, and the program
    /// continued after this attempt or stopped in good order.
    #[must_use]
    pub fn should_be_saved(&self, attempt: &Attempt) -> bool {
        let mut saved_attempts = self
            .attempts
            .values()
            .filter(|candidate| candidate.is_saved);
        let is_later =
            |candidate: &Attempt| candidate.part == attempt.part && candidate.label > attempt.label;
        if self.stopped_parts.contains(&attempt.part) {
            saved_attempts.next().is_some()
        } else {
            saved_attempts.any(is_later)
        }
    }

    /// Requires all trials to be settled if the stop calls the session complete.
    fn require_all_settled(&mut self) {
        let is_complete = matches!(
            self.end,
            SessionEndFinding::Stopped {
                status: ExitStatus::Success,
                ..
            }
        );
        let is_settled = |attempt: &&Attempt| {
            let is_main = attempt.label.block == TrialBlock::Main;
            is_main && attempt.outcome.as_ref().is_some_and(TrialOutcome::settles)
        };
        let settled_numbers = self.attempts.values().filter(is_settled);
        let settled_numbers: BTreeSet<u32> = settled_numbers
            .map(|attempt| attempt.label.number)
            .collect();
        let planned = self.planned.unwrap_or(0);
        if is_complete && settled_numbers.len() < planned {
            self.defects.push(SessionDefect::NotAllSettled {
                planned,
                settled: settled_numbers.len(),
            });
        }
    }
}

impl Reading {
    fn read(&mut self, number: usize, document: &Document) {
        let is_start = matches!(document, Document::Start(_));
        if !is_start && !self.is_running {
            self.defect(SessionDefect::NoStart { document: number });
            // Reported once.
            self.is_running = true;
        }
        match document {
            Document::Start(start) => {
                self.is_running = true;
                self.part += 1;
                self.audio_s = f64::NEG_INFINITY;
                self.open_trial = None;
                self.history.start = Some((**start).clone());
                self.history.end = SessionEndFinding::Unfinished;
            }
            Document::Descriptor(descriptor) => {
                self.streams.insert(descriptor.stream.clone());
            }
            Document::Event(event) => self.event(event),
            Document::Stop(stop) => {
                self.is_running = false;
                self.history.stopped_parts.insert(self.part);
                if stop.num_events != self.n_events {
                    self.defect(SessionDefect::Count {
                        expected: stop.num_events,
                        found: self.n_events,
                    });
                }
                self.history.end = SessionEndFinding::Stopped {
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
        if number != self.n_events + 1 {
            self.defect(SessionDefect::Number {
                expected: self.n_events + 1,
                found: number,
            });
        }
        // One missing line counts as one defect.
        self.n_events = number;
        let late_s = self.audio_s - event.audio_s;
        let is_late_display =
            event.stream == DISPLAY_STREAM && late_s <= LATE_DISPLAY_S + ROUNDING_S;
        if late_s > 0.0 && !is_late_display {
            self.defect(SessionDefect::Time {
                number,
                audio_s: event.audio_s,
                before_s: self.audio_s,
            });
        }
        // After a late event of the window, the next one is compared with the event before it.
        if !(late_s > 0.0 && is_late_display) {
            self.audio_s = event.audio_s;
        }
        if !self.streams.contains(&event.stream) {
            self.defect(SessionDefect::Undescribed {
                number,
                stream: event.stream.clone(),
            });
            self.streams.insert(event.stream.clone());
        }
        match session_event(event) {
            Some(SessionEventKind::TrialBegan { key }) => {
                let trial = TrialLabel::new(&key, self.practice_trials);
                if self.open_trial.is_some() {
                    self.order_defect(
                        number,
                        trial,
                        "began before the trial before it was settled",
                    );
                }
                if !self.begun_trials.insert(trial) {
                    self.order_defect(number, trial, "began twice");
                }
                self.open_trial = Some(trial);
            }
            Some(SessionEventKind::TrialSettled { record }) => {
                let trial = TrialLabel::new(&record.key, self.practice_trials);
                let is_withdrawn = is_not_saved(&record)
                    && self.open_trial.is_none()
                    && self.settled_trials.remove(&trial);
                if is_withdrawn {
                    return;
                }
                if self.open_trial.take() != Some(trial) {
                    self.order_defect(number, trial, "was settled and had not begun");
                }
                if record.outcome.settles() {
                    self.settled_trials.insert(trial);
                }
            }
            Some(_) => {}
            None => {
                let name = event.data.get("saved").and_then(Value::as_str);
                let saved_label = name.and_then(|name| name.parse::<TrialLabel>().ok());
                if let Some(trial) = saved_label.filter(|trial| !self.begun_trials.contains(trial))
                {
                    self.order_defect(number, trial, "was saved and had not begun");
                }
            }
        }
    }

    fn order_defect(&mut self, number: u64, trial: TrialLabel, fault: &'static str) {
        self.defect(SessionDefect::Order {
            number,
            trial,
            fault,
        });
    }
}

/// Returns whether an attempt counts as interrupted because its recording was not saved.
fn is_not_saved(record: &TrialRecord) -> bool {
    let interruption = match &record.outcome {
        TrialOutcome::Interrupted { interruption } => interruption,
        _ => return false,
    };
    matches!(interruption, Interruption::NotSaved { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sessions::{Standing, practice_trials};

    /// Returns the lines of a log of one trial with `events` as the trial's events.
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
        SessionHistory::from_log(&content, practice_trials(&content))
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
        let history = history(&[
            &begin_line(1, 1),
            &save_line(2, FIRST),
            &settle_line(3, 1),
            stop,
        ]);
        assert_eq!(history.defects, []);
        let attempt = &history.attempts[&label(FIRST)];
        assert_eq!(attempt.standing(), Standing::Accepted);
        assert!(attempt.is_saved);
        assert_eq!(attempt.sums.as_ref().unwrap()["force.csv"], "ab");
        assert!(matches!(history.end, SessionEndFinding::Stopped { .. }));
        assert!(!attempt.is_interrupted);
    }

    #[test]
    fn a_trial_interrupted_by_the_programs_end_is_saved() {
        let save_line =
            save_line(2, FIRST).replace(r#""sha256""#, r#""interrupted":true,"sha256""#);
        let stop = r#"{"document":"stop","time":"","exit_status":"abort","num_events":2}"#;
        let history = history(&[&begin_line(1, 1), &save_line, stop]);
        assert_eq!(history.defects, []);
        let attempt = &history.attempts[&label(FIRST)];
        assert_eq!(attempt.outcome, None);
        assert!(attempt.is_saved && attempt.is_interrupted && attempt.sums.is_some());
    }

    #[test]
    fn each_disorder_is_one_defect() {
        let stop = r#"{"document":"stop","time":"","exit_status":"success","num_events":2}"#;
        let early_event = event(2, 0.5, "{}");
        let other_stream_event = event(2, 2.0, "{}").replace("\"session\"", "\"other\"");
        let defects = |events: &[&str]| history(events).defects;
        let is_order = |defects: &[SessionDefect]| matches!(defects, [SessionDefect::Order { .. }]);
        let first = begin_line(1, 1);
        assert!(matches!(
            defects(&[&first, &settle_line(3, 1)])[..],
            [SessionDefect::Number {
                expected: 2,
                found: 3
            }]
        ));
        assert!(matches!(
            defects(&[&first, &early_event])[..],
            [SessionDefect::Time { number: 2, .. }]
        ));
        assert!(matches!(
            defects(&[&first, &other_stream_event])[..],
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
        let lift_line =
            |number, audio_s| event(number, audio_s, r#"{"event":"phase","phase":"lift"}"#);
        let time_defects = |events: &[String]| {
            let events = events.iter().map(String::as_str);
            let lines: Vec<_> = std::iter::once(descriptor).chain(events).collect();
            history(&lines).defects
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
            [SessionDefect::Time { number, .. }] => assert_eq!(number, event_number),
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
            history(&lines.collect::<Vec<_>>())
        };
        let history = log(&[start, &loss_line(4)]);
        assert_eq!(history.defects, []);
        let attempt = &history.attempts[&label(FIRST)];
        assert_eq!(attempt.standing(), Standing::Interrupted);
        let is_order =
            |history: SessionHistory| matches!(history.defects[..], [SessionDefect::Order { .. }]);
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
            let history = history(events);
            history.should_be_saved(&history.attempts[&label(FIRST)])
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
        let complete = history(&[&start_event, &begin_line(2, 1), &settle_line(3, 1), stop]);
        assert_eq!(
            complete.defects,
            [SessionDefect::NotAllSettled {
                planned: 2,
                settled: 1
            }]
        );
        let stop = stop.replace("success", "abort");
        let aborted = history(&[&start_event, &begin_line(2, 1), &settle_line(3, 1), &stop]);
        assert_eq!(aborted.defects, []);
    }
}
