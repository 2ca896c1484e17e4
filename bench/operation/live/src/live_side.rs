//! Live values and contact estimates of a session, for its operator.

use std::collections::VecDeque;

use crate::live_contact::LiveContact;
use crate::trial_fit::FitRequest;
use contact::plate_tracker::PlateTracking;
use contact::uncertain::Uncertain;
use crossbeam_channel::{Receiver, Sender};
use recording::pipeline::Batch;
use serde_json::{Map, Value};

use tui::action::AttemptName;

use crate::fit_report::FitReport;
use crate::live_meter::LiveMeter;
use crate::screen_words;

/// Time between two updates of the screen, ns.
const SCREEN_PERIOD_NS: u64 = 16_000_000;

/// Live values and contact of a session.
pub struct LiveSide {
    /// The newest values.
    pub meter: LiveMeter,
    contact: LiveContact,
    screen_due_ns: u64,
    refits: Sender<FitRequest>,
    fits: Receiver<FitReport>,
    /// Number of each trial with a requested fit, whether it is practice, and its attempt.
    requested_attempts: VecDeque<AttemptName>,
}

/// Outcome of a fit.
pub struct FitNews {
    /// Entry for the log.
    pub data: Map<String, Value>,
    /// View for the screen.
    pub view: tui::event::FitView,
}

impl LiveSide {
    /// Creates the live side of a session with its trials fitted at the other end of `refits` and `fits`. A normal force of at
    /// least `contact_n`, N, means that a finger is on the plate.
    pub fn new(
        contact_n: f64,
        modal_mass_kg: f64,
        (refits, fits): (Sender<FitRequest>, Receiver<FitReport>),
    ) -> Self {
        Self {
            meter: LiveMeter::default(),
            contact: LiveContact::new(contact_n, PlateTracking::new(modal_mass_kg, 0.0)),
            screen_due_ns: 0,
            refits,
            fits,
            requested_attempts: VecDeque::new(),
        }
    }

    /// Takes a batch of acquired data.
    pub fn take(&mut self, batch: &Batch) {
        self.meter.take(batch);
        self.contact.take(batch, |_| {});
    }

    /// Sets the frequency of the drive's modulation, Hz.
    pub fn modulate(&mut self, modulation_hz: f64) {
        self.meter.modulate(modulation_hz);
        self.contact.modulate(modulation_hz);
    }

    /// Returns the drift of the plate's resonance, Hz.
    pub fn drift_hz(&self) -> Option<Uncertain> {
        self.contact.drift_hz()
    }

    /// Continues at a carrier that is higher by `by_hz`.
    pub fn retune(&mut self, shift_hz: f64) {
        self.contact.retune(shift_hz);
    }

    /// Requests the fit of an attempt. A fit takes longer than a step may;
    /// [`take_fit`](Self::take_fit) returns it later. The fitting task ends before the session only if it failed, and that
    /// stops the bench.
    pub fn ask(&mut self, request: FitRequest, attempt: AttemptName) {
        self.requested_attempts.push_back(attempt);
        let _ = self.refits.send(request);
    }

    /// Takes the next finished fit into account, and returns its outcome.
    pub fn take_fit(&mut self) -> Option<FitNews> {
        let report = self.fits.try_recv().ok()?;
        if let Ok(fit) = &report.fit {
            self.contact.refit(fit);
        }
        let drift_hz = self.contact.drift_hz();
        // Each report answers one request, in order.
        let attempt = self.requested_attempts.pop_front().unwrap_or_default();
        Some(FitNews {
            data: report.record(drift_hz),
            view: report.view(attempt, drift_hz),
        })
    }

    /// Returns the newest values for the screen, when it is due.
    pub fn next_event(&mut self, now_ns: u64, slider_m: Option<f64>) -> Option<tui::event::Live> {
        if now_ns < self.screen_due_ns {
            return None;
        }
        self.screen_due_ns = now_ns + SCREEN_PERIOD_NS;
        let live = self.meter.live(slider_m)?;
        Some(screen_words::with_contact(live, &self.contact))
    }
}
