//! The one pass over a session's log, from its documents to the session's history.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use protocols::{AttemptRecords, SessionEventKind, TrialKey, TrialOutcome, TrialRecord};
use recording::study::event_log::{Document, ExitStatus, LogContent, LogEvent, Start};
use recording::study::{TrialBlock, TrialLabel};
use serde_json::Value;

use crate::sessions::log_defect::LogDefect;
use crate::sessions::order::Order;
use crate::sessions::session::{Attempt, CarrierChange, LoggedFit, LoggedSession, SessionEnd};

/// Longest time between two recordings of a session, resumed ones included, s: a month.
const LONGEST_S: f64 = 31.0 * 86_400.0;

/// Returns the history of a session that begins with `practice_trials` practice trials.
#[must_use]
pub fn history(content: &LogContent, practice_trials: u32) -> LoggedSession {
    let mut fold = Fold::new(practice_trials);
    for document in &content.documents {
        fold.document(document);
    }
    fold.end()
}

/// Returns the number of practice trials by the log's events: the number of the first other trial, less one.
pub(super) fn logged_practice(content: &LogContent) -> u32 {
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

/// State of the pass.
struct Fold {
    session: LoggedSession,
    order: Order,
    records: AttemptRecords,
    practice_trials: u32,
    /// Current part of the session, from 1.
    part: usize,
    /// Time of the session's first start.
    first_time: Option<Timestamp>,
    /// Start of the current part, when its audio clock begins, s after the session's first start.
    part_s: f64,
    /// Calibrated resonance of the current part, Hz.
    calibrated_hz: Option<f64>,
    /// Whether the current part changed the carrier.
    is_carrier_changed: bool,
    /// Attempt at each trial that began last, by the name of the trial in a fit.
    last_attempts: BTreeMap<String, TrialLabel>,
}

impl Fold {
    fn new(practice_trials: u32) -> Self {
        Self {
            session: LoggedSession::default(),
            order: Order::new(),
            records: AttemptRecords::default(),
            practice_trials,
            part: 0,
            first_time: None,
            part_s: 0.0,
            calibrated_hz: None,
            is_carrier_changed: false,
            last_attempts: BTreeMap::new(),
        }
    }

    fn document(&mut self, document: &Document) {
        self.order.document(document);
        match document {
            Document::Start(start) => self.start(start),
            Document::Event(event) => self.event(event),
            Document::Stop(stop) => {
                self.session.stopped_parts.insert(self.part);
                self.session.end = SessionEnd::Stopped {
                    status: stop.exit_status,
                    reason: stop.reason.clone(),
                };
            }
            Document::Descriptor(_) => {}
        }
    }

    fn start(&mut self, start: &Start) {
        let time: Option<Timestamp> = start.time.parse().ok();
        self.first_time = self.first_time.or(time);
        let since_first = self
            .first_time
            .zip(time)
            .map(|(first_time, time)| time.duration_since(first_time));
        self.part += 1;
        // The wall clock may be set back.
        self.part_s = since_first
            .map_or(self.part_s, |since_first| since_first.as_secs_f64())
            .max(self.part_s);
        self.calibrated_hz = start.configuration["plate"]["resonance_hz"].as_f64();
        self.is_carrier_changed = false;
        self.session.end = SessionEnd::Unfinished;
        self.session.last_start = Some(start.clone());
        match &self.session.start {
            None => self.session.start = Some(start.clone()),
            Some(_) => self.session.n_resumptions += 1,
        }
    }

    fn event(&mut self, event: &LogEvent) {
        let kind = session_event(event);
        if let Some(kind) = &kind {
            self.records.read(kind);
        }
        self.carrier_event(event);
        match kind {
            Some(SessionEventKind::SessionStarted { order, .. }) => {
                let practice = self.practice_trials as usize;
                self.session.planned = Some(order.len().saturating_sub(practice));
            }
            Some(SessionEventKind::TrialBegan { key }) => self.trial_began(event, &key),
            Some(SessionEventKind::Marked { interval }) => {
                if let Some(label) = self.order.open_trial() {
                    self.attempt(label, "").intervals.push(interval);
                }
            }
            Some(SessionEventKind::TrialSettled { record }) => self.trial_settled(record),
            Some(_) => {}
            None => {
                self.recording_saved(event);
                self.fit(event);
            }
        }
    }

    fn trial_began(&mut self, event: &LogEvent, key: &TrialKey) {
        let start_s = self.part_s + event.audio_s;
        let label = TrialLabel::new(key, self.practice_trials);
        self.order.began(label);
        self.attempt(label, &key.condition).start_s = Some(start_s);
        self.last_attempts.insert(label.trial_name(), label);
    }

    fn trial_settled(&mut self, record: TrialRecord) {
        let label = TrialLabel::new(&record.key, self.practice_trials);
        self.order.settled(label, &record);
        self.attempt(label, &record.key.condition).outcome = Some(record.outcome);
    }

    fn recording_saved(&mut self, event: &LogEvent) {
        let Some(label) = text(event, "saved").and_then(|name| name.parse().ok()) else {
            return;
        };
        self.order.saved(label);
        let sums = event.data.get("sha256").cloned();
        let is_interrupted = event.data.get("interrupted").and_then(Value::as_bool);
        let attempt = self.attempt(label, "");
        attempt.is_saved = true;
        attempt.is_interrupted = is_interrupted.unwrap_or(false);
        attempt.sums = sums.and_then(|sums| serde_json::from_value(sums).ok());
    }

    fn fit(&mut self, event: &LogEvent) {
        if text(event, "event") == Some("fit") {
            // A fit names only its trial; it belongs to the attempt that began last.
            let attempt = text(event, "of").and_then(|name| self.last_attempts.get(name));
            self.session.fits.push(LoggedFit {
                attempt: attempt.copied(),
                data: event.data.clone(),
            });
        }
    }

    fn carrier_event(&mut self, event: &LogEvent) {
        match text(event, "event") {
            Some("carrier_changed") => {
                self.session.carrier_change = Some(CarrierChange {
                    calibrated_hz: self.calibrated_hz,
                    data: event.data.clone(),
                });
                self.is_carrier_changed = true;
            }
            // A part recorded by an earlier version, which returned to the calibrated resonance.
            Some("trial_began") if !self.is_carrier_changed => self.session.carrier_change = None,
            _ => {}
        }
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

    fn end(self) -> LoggedSession {
        let mut session = self.session;
        let origin_s = session.attempts.first().and_then(|first| first.start_s);
        for attempt in &mut session.attempts {
            let offset_s = attempt
                .start_s
                .zip(origin_s)
                .map(|(start_s, origin_s)| start_s - origin_s);
            attempt.start_s = offset_s.filter(|offset_s| (0.0..=LONGEST_S).contains(offset_s));
        }
        session.records = self.records.records();
        session.defects = self.order.defects();
        session.defects.extend(unsettled_trials(&session));
        session
    }
}

/// Returns the defect of a log that calls the session complete without all of its trials.
fn unsettled_trials(session: &LoggedSession) -> Option<LogDefect> {
    let is_complete = matches!(
        session.end,
        SessionEnd::Stopped {
            status: ExitStatus::Success,
            ..
        }
    );
    let is_settled = |attempt: &&Attempt| {
        let is_main = attempt.label.block == TrialBlock::Main;
        is_main && attempt.outcome.as_ref().is_some_and(TrialOutcome::settles)
    };
    let settled_attempts = session.attempts.iter().filter(is_settled);
    let settled_numbers: BTreeSet<u32> = settled_attempts
        .map(|attempt| attempt.label.number)
        .collect();
    let planned = session.planned.unwrap_or(0);
    (is_complete && settled_numbers.len() < planned).then_some(LogDefect::NotAllSettled {
        planned,
        settled: settled_numbers.len(),
    })
}

fn text<'a>(event: &'a LogEvent, key: &str) -> Option<&'a str> {
    event.data.get(key).and_then(Value::as_str)
}

/// Parses an event of the log as one of the protocol's state machine; `None` if it is another kind of event.
fn session_event(event: &LogEvent) -> Option<SessionEventKind> {
    serde_json::from_value(Value::Object(event.data.clone())).ok()
}

#[cfg(test)]
mod order_tests;
#[cfg(test)]
mod tests;
