//! A session's display: phase and participant's view, live values, outlook, system health.

use devices::loudspeaker::Tone;
use live::outlook::OutlookTracker;
use live::screen_words;
use protocols::{ParticipantView, Session};
use tui::event::PhaseView;

use super::acquired::Acquired;
use super::wiring::Wiring;

/// Time between two updates of the outlook, s.
const OUTLOOK_EVERY_S: f64 = 0.25;
/// Time between two traces of the last period, ns.
const PERIOD_EVERY_NS: u64 = 250_000_000;

/// Display of a session: each part is shown when it changes or is due.
#[derive(Default)]
pub(super) struct AtAGlance {
    /// Remaining time.
    pub(super) outlook: OutlookTracker,
    outlook_due_s: f64,
    period_due_ns: u64,
    phase: Option<PhaseView>,
    /// The participant's view.
    pub(super) view: Option<ParticipantView>,
}

impl AtAGlance {
    /// Shows the phase and the participant's view if they have changed; a tone always goes with a view.
    pub(super) fn show(
        &mut self,
        wiring: &mut Wiring,
        machine: &Session,
        view: ParticipantView,
        (tone, audio_s): (Option<Tone>, f64),
    ) {
        let phase = screen_words::phase(machine, &view);
        if self.phase.as_ref() != Some(&phase) {
            wiring.front.show(tui::Event::Phase(phase.clone()));
            self.phase = Some(phase);
            // The next steps follow the phase at once.
            self.outlook_due_s = audio_s;
        }
        if tone.is_some() || self.view.as_ref() != Some(&view) {
            let screen_view = wiring.screen.view(&view, audio_s);
            wiring.displays.show(&screen_view);
            for watcher in &mut wiring.watchers {
                watcher(&screen_view, view.button, tone);
            }
            wiring.front.show(tui::Event::Participant(screen_view));
            self.view = Some(view);
        }
    }

    /// Shows the views that are due; returns whether system health was due, which is twice a second.
    pub(super) fn feed(
        &mut self,
        wiring: &mut Wiring,
        machine: &Session,
        acquired: &Acquired,
        (rate_hz, now_ns): (u32, u64),
    ) -> bool {
        let (view, audio_s) = (self.view.as_ref(), acquired.audio_s);
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
        let Some(health) = meter.read(now_ns, &acquired.account, &wiring.gauges, rate_hz) else {
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
