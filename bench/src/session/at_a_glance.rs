//! A session's display apart from its phase: live values, decided crops, outlook, system health.

use std::collections::VecDeque;

use analysis::measurements::Measurements;
use config::Effective;
use live::exploration_crop::{ExplorationName, crop};
use live::outlook::OutlookTracker;
use protocols::selection::analyse_exploration;
use protocols::{Direction, Interval, IntervalKind, ParticipantView, Protocol, Session, TrialKey};
use recording::pipeline::Account;
use recording::study::TrialLabel;

use super::due_trial::DATA_DELAY_S;
use super::wiring::Wiring;

/// Time between two updates of the outlook, s.
const OUTLOOK_EVERY_S: f64 = 0.25;
/// Time between two traces of the last period, ns.
const PERIOD_EVERY_NS: u64 = 250_000_000;

/// Feeds the screen.
#[derive(Default)]
pub(super) struct AtAGlance {
    outlook: OutlookTracker,
    outlook_due_s: f64,
    period_due_ns: u64,
    /// Running attempt, and its number of explorations so far.
    running: Option<ExplorationName>,
    /// Completed explorations that are not decided yet.
    waiting: VecDeque<(ExplorationName, Direction, (f64, f64))>,
}

impl AtAGlance {
    /// Begins an attempt.
    pub(super) fn begin(&mut self, key: &TrialKey, protocol: &Protocol, now_s: f64) {
        self.outlook.begin(now_s);
        self.waiting.clear();
        self.running = Some(ExplorationName {
            trial: TrialLabel::new(key, protocol.trials.practice).number,
            practice: key.practice,
            attempt: key.attempt,
            exploration: 0,
        });
    }

    /// Takes a completed interval of the attempt.
    pub(super) fn mark(&mut self, interval: &Interval) {
        if let (IntervalKind::Exploration { direction }, Some(running)) =
            (interval.kind, &mut self.running)
        {
            running.exploration += 1;
            let span_s = (interval.start_s, interval.end_s);
            self.waiting.push_back((*running, direction, span_s));
        }
    }

    /// Ends an interrupted attempt.
    pub(super) fn broken_off(&mut self) {
        self.running = None;
        self.waiting.clear();
        self.outlook.broken_off();
    }

    /// Takes note that the attempt was judged.
    pub(super) fn judged(&mut self, now_s: f64) {
        self.outlook.judged(now_s);
    }

    /// Returns the crops of the explorations with all their data in `record` at `now_s`.
    pub(super) fn crops(
        &mut self,
        now_s: f64,
        record: &Measurements,
        (protocol, bench): (&Protocol, &Effective),
    ) -> Vec<tui::event::Crop> {
        let mut crops = Vec::new();
        let complete = |span_s: (f64, f64)| span_s.1 + DATA_DELAY_S <= now_s;
        let complete = self
            .waiting
            .iter()
            .take_while(|(.., span_s)| complete(*span_s));
        let count = complete.count();
        for (name, direction, span_s) in self.waiting.drain(..count) {
            let rules = protocol.selection_rules(bench.config().plate.centre_m);
            let series = record.series(span_s.0, span_s.1);
            let analysis = analyse_exploration(&series.exploration(direction), &rules);
            let stretches = analysis.map_or_else(|_| Vec::new(), |analysis| analysis.stretches);
            crops.push(crop(name, direction, span_s, &series, &stretches));
        }
        crops
    }

    /// Shows the views that are due; returns whether system health was due, which is twice a second.
    pub(super) fn feed(
        &mut self,
        wiring: &mut Wiring,
        (machine, view): (&Session, Option<&ParticipantView>),
        (account, rate_hz): (&Account, u32),
        (now_ns, audio_s): (u64, f64),
    ) -> bool {
        let slider_m = view.and_then(|view| view.slider_m);
        if let Some(live) = wiring.live.next_event(now_ns, slider_m) {
            wiring.front.show(tui::Event::Live(live));
        }
        if now_ns >= self.period_due_ns {
            self.period_due_ns = now_ns + PERIOD_EVERY_NS;
            if let Some(period) = wiring.live.meter.period() {
                wiring.front.show(tui::Event::Period(period));
            }
        }
        if audio_s >= self.outlook_due_s {
            self.outlook_due_s = audio_s + OUTLOOK_EVERY_S;
            let progress = view.and_then(|view| view.progress.as_ref());
            if let Some(outlook) = self.outlook.update(machine, progress, audio_s) {
                wiring.front.show(tui::Event::Outlook(outlook));
            }
        }
        let meter = &mut wiring.live.meter.health;
        let Some(health) = meter.read(now_ns, account, &wiring.gauges, rate_hz) else {
            return false;
        };
        let free_bytes = wiring.room.free_bytes(now_ns);
        let room = |bytes: u64| bytes.checked_div(wiring.session_bytes);
        wiring
            .front
            .show(tui::Event::Health(tui::event::SystemHealth {
                recorder_lag_s: wiring.behind_s(),
                disk_free_bytes: free_bytes,
                disk_sessions: free_bytes.and_then(room),
                ..health
            }));
        true
    }
}
