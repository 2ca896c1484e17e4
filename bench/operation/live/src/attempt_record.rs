//! Data of an attempt in progress.

use std::collections::VecDeque;

use analysis::force_zero::ForceZero;
use analysis::measurements::Measurements;
use config::Effective;
use protocols::selection::analyse_exploration;
use protocols::{Direction, Interval, IntervalKind, Protocol, TrialKey, TrialLabel};
use recording::pipeline::Account;
use tui::event::Crop;

use crate::exploration_crop::{ExplorationName, crop};

/// Time within which the data of the last exploration arrive after its end, s: a force sensor's burst, the demodulator's
/// delay.
pub const DATA_DELAY_S: f64 = 0.06;

/// Data of an attempt, and its explorations.
pub struct AttemptRecord {
    /// Data so far.
    pub measurements: Measurements,
    /// Carrier of the recording, Hz.
    pub carrier_hz: f64,
    /// Account of the audio frames at the beginning.
    pub account: Account,
    /// Attempt, and its number of explorations so far.
    name: ExplorationName,
    /// Completed intervals without a finger, s.
    unloaded_s: Vec<(f64, f64)>,
    /// Completed explorations that are not decided yet.
    waiting: VecDeque<(ExplorationName, Direction, (f64, f64))>,
}

impl AttemptRecord {
    /// Creates the empty record of an attempt at its carrier.
    pub fn new(key: &TrialKey, protocol: &Protocol, carrier_hz: f64, account: Account) -> Self {
        Self {
            measurements: Measurements::default(),
            carrier_hz,
            account,
            name: ExplorationName {
                attempt: TrialLabel::new(key, protocol.trials.practice),
                exploration: 0,
            },
            unloaded_s: Vec::new(),
            waiting: VecDeque::new(),
        }
    }

    /// Takes a completed interval.
    pub fn mark(&mut self, interval: &Interval) {
        let span_s = (interval.start_s, interval.end_s);
        match interval.kind {
            IntervalKind::Unloaded => self.unloaded_s.push(span_s),
            IntervalKind::Exploration { direction } => {
                self.name.exploration += 1;
                self.waiting.push_back((self.name, direction, span_s));
            }
        }
    }

    /// Returns the crops of the explorations with all their data at `now_s`, with the forces against the zero so far.
    pub fn crops(&mut self, now_s: f64, (protocol, bench): (&Protocol, &Effective)) -> Vec<Crop> {
        let rules = protocol.selection_rules(bench.config().plate.centre_m);
        let is_complete = |span_s: (f64, f64)| span_s.1 + DATA_DELAY_S <= now_s;
        let complete = self
            .waiting
            .iter()
            .take_while(|(.., span_s)| is_complete(*span_s));
        let count = complete.count();
        let complete = self.waiting.drain(..count);
        let crops = complete.map(|(name, direction, span_s)| {
            let (record, _) = ForceZero::tare(&self.measurements, &self.unloaded_s, span_s.1);
            let series = record.series(span_s.0, span_s.1);
            let analysis = analyse_exploration(&series.exploration(direction), &rules);
            let stretches = analysis.map_or_else(|_| Vec::new(), |analysis| analysis.stretches);
            crop(name, direction, span_s, &series, &stretches)
        });
        crops.collect()
    }
}
