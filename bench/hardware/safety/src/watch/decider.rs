//! Signs of life of the task that decides about the drive and of the thread that reads the operator's stop key.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::signals::Signals;
use crate::trip::Trip;

/// Longest time between two polls of a thread that an armed drive depends on, ns: an assumption. The thread polls every
/// few milliseconds, so this is a hang, and shorter than a person takes to notice one.
const UNRESPONSIVE_NS: u64 = 1_000_000_000;

/// Shortest suspension of the computer that trips, ns: longer than any time between the readings of the two clocks that
/// show it.
const SUSPENDED_NS: u64 = 1_000_000_000;

/// Polls of one thread, and the time at which the last one was seen.
#[derive(Debug, Default)]
struct Looks {
    count: u64,
    seen_ns: u64,
}

impl Looks {
    /// Returns the time from the last poll, or from `from_ns` if that is later, to `now_ns`, s; `None` within
    /// [`UNRESPONSIVE_NS`].
    fn missing(&mut self, count: &AtomicU64, from_ns: u64, now_ns: u64) -> Option<f64> {
        let count = count.load(Ordering::Relaxed);
        if count != self.count {
            *self = Self {
                count,
                seen_ns: now_ns,
            };
        }
        let absence_ns = now_ns.saturating_sub(self.seen_ns.max(from_ns));
        (absence_ns > UNRESPONSIVE_NS).then_some(absence_ns as f64 * 1e-9)
    }
}

/// Polls of the task that decides about the drive and of the thread that reads the keys, and suspensions of the
/// computer.
#[derive(Debug, Default)]
pub(super) struct Decider {
    decisions: Looks,
    hearings: Looks,
    suspended_ns: u64,
}

impl Decider {
    /// Returns the trip of a computer that was suspended since the last poll.
    pub(super) fn suspended(&mut self, signals: &Signals) -> Option<Trip> {
        let suspended_ns = signals.suspended_ns.load(Ordering::Relaxed);
        let slept_ns = suspended_ns.saturating_sub(self.suspended_ns);
        // A misread value lasts only until the next one.
        self.suspended_ns = suspended_ns;
        (slept_ns > SUSPENDED_NS).then_some(Trip::Frozen {
            for_s: slept_ns as f64 * 1e-9,
        })
    }

    /// Returns the trip of a bench that was armed at `armed_at_ns` and on which either has not polled for too long at
    /// `now_ns`. Keys that were never read are not missed.
    pub(super) fn look(
        &mut self,
        signals: &Signals,
        armed_at_ns: u64,
        now_ns: u64,
    ) -> Option<Trip> {
        let unresponsive = self
            .decisions
            .missing(&signals.decisions, armed_at_ns, now_ns);
        let keys_unread = self
            .hearings
            .missing(&signals.hearings, armed_at_ns, now_ns)
            .filter(|_| self.hearings.count > 0);
        unresponsive
            .map(|for_s| Trip::Unresponsive { for_s })
            .or(keys_unread.map(|for_s| Trip::KeysUnread { for_s }))
    }
}
