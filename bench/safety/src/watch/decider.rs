//! The sign of life of the task that decides about the drive.

use std::sync::atomic::Ordering;

use crate::signals::Signals;
use crate::trip::Trip;

/// Longest time between two looks of the task that decides about an armed drive, ns: an assumption. It looks every few
/// milliseconds, so this is a hang, and shorter than a person takes to notice one.
const UNRESPONSIVE_NS: u64 = 1_000_000_000;

/// Looks of the task that decides about the drive, and when the last one was seen.
#[derive(Debug, Default)]
pub(super) struct Decider {
    looks: u64,
    seen_ns: u64,
}

impl Decider {
    /// Returns the trip of a bench that was armed at `armed_at_ns` and whose task has not looked for too long at `now_ns`.
    pub(super) fn look(
        &mut self,
        signals: &Signals,
        armed_at_ns: u64,
        now_ns: u64,
    ) -> Option<Trip> {
        let looks = signals.decisions.load(Ordering::Relaxed);
        if looks != self.looks {
            *self = Self {
                looks,
                seen_ns: now_ns,
            };
        }
        let away_ns = now_ns.saturating_sub(self.seen_ns.max(armed_at_ns));
        (away_ns > UNRESPONSIVE_NS).then_some(Trip::Unresponsive {
            for_s: away_ns as f64 * 1e-9,
        })
    }
}
