//! Order of the events in a session's log.

use std::collections::BTreeSet;

use protocols::{Interruption, TrialOutcome, TrialRecord};
use recording::study::TrialLabel;
use recording::study::event_log::{Document, LogEvent, Stop};

use crate::sessions::log_defect::LogDefect;

/// Stream of the participant window.
const DISPLAY_STREAM: &str = "display";
/// Longest delay of an event of the window, s. In early versions the window read the audio clock separately, up to
/// one period of the session earlier than the session did; the log's own clock is the same.
const LATE_DISPLAY_S: f64 = 0.010;
/// Rounding error of a difference between two times of a log, s.
const ROUNDING_S: f64 = 1e-9;

/// Order of a log, checked from one document to the next.
#[derive(Debug)]
pub(super) struct Order {
    defects: Vec<LogDefect>,
    n_documents: usize,
    is_running: bool,
    n_events: u64,
    audio_s: f64,
    streams: BTreeSet<String>,
    begun_trials: BTreeSet<TrialLabel>,
    /// Trials settled by an attempt; a later part of the session may revoke this.
    settled_trials: BTreeSet<TrialLabel>,
    open_trial: Option<TrialLabel>,
}

impl Order {
    pub(super) fn new() -> Self {
        Self {
            defects: Vec::new(),
            n_documents: 0,
            is_running: false,
            n_events: 0,
            audio_s: f64::NEG_INFINITY,
            streams: BTreeSet::new(),
            begun_trials: BTreeSet::new(),
            settled_trials: BTreeSet::new(),
            open_trial: None,
        }
    }

    /// Returns the attempt in progress.
    pub(super) fn open_trial(&self) -> Option<TrialLabel> {
        self.open_trial
    }

    /// Returns the defects.
    pub(super) fn defects(self) -> Vec<LogDefect> {
        self.defects
    }

    /// Takes the next document.
    pub(super) fn document(&mut self, document: &Document) {
        self.n_documents += 1;
        let is_start = matches!(document, Document::Start(_));
        if !is_start && !self.is_running {
            self.defects.push(LogDefect::NoStart {
                document: self.n_documents,
            });
            // Reported once.
            self.is_running = true;
        }
        match document {
            Document::Start(_) => {
                self.is_running = true;
                self.audio_s = f64::NEG_INFINITY;
                self.open_trial = None;
            }
            Document::Descriptor(descriptor) => {
                self.streams.insert(descriptor.stream.clone());
            }
            Document::Event(event) => self.event(event),
            Document::Stop(stop) => self.stop(stop),
        }
    }

    fn stop(&mut self, stop: &Stop) {
        self.is_running = false;
        if stop.num_events != self.n_events {
            self.defects.push(LogDefect::Count {
                expected: stop.num_events,
                found: self.n_events,
            });
        }
    }

    fn event(&mut self, event: &LogEvent) {
        let number = event.seq_num;
        if number != self.n_events + 1 {
            self.defects.push(LogDefect::Number {
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
            self.defects.push(LogDefect::Time {
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
            self.defects.push(LogDefect::Undescribed {
                number,
                stream: event.stream.clone(),
            });
            self.streams.insert(event.stream.clone());
        }
    }

    /// Takes the start of an attempt, in the last event.
    pub(super) fn began(&mut self, trial: TrialLabel) {
        if self.open_trial.is_some() {
            self.fault(trial, "began before the trial before it was settled");
        }
        if !self.begun_trials.insert(trial) {
            self.fault(trial, "began twice");
        }
        self.open_trial = Some(trial);
    }

    /// Takes the outcome of an attempt, in the last event.
    pub(super) fn settled(&mut self, trial: TrialLabel, record: &TrialRecord) {
        let is_withdrawn =
            is_not_saved(record) && self.open_trial.is_none() && self.settled_trials.remove(&trial);
        if is_withdrawn {
            return;
        }
        if self.open_trial.take() != Some(trial) {
            self.fault(trial, "was settled and had not begun");
        }
        if record.outcome.settles() {
            self.settled_trials.insert(trial);
        }
    }

    /// Takes the saving of an attempt's recording, in the last event.
    pub(super) fn saved(&mut self, trial: TrialLabel) {
        if !self.begun_trials.contains(&trial) {
            self.fault(trial, "was saved and had not begun");
        }
    }

    fn fault(&mut self, trial: TrialLabel, fault: &'static str) {
        self.defects.push(LogDefect::Order {
            number: self.n_events,
            trial,
            fault: fault.into(),
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
