//! Time on the host: monotonic nanoseconds, and a calendar date that cannot jump while the program runs.

use std::time::Instant;

use jiff::{SignedDuration, Timestamp};

/// What time it is for the bench. Everything that stamps an arrival or writes a date asks this, so that a
/// free-running apparatus can bring its own time and give the same files twice.
pub trait Clock: Send + Sync {
    /// Monotonic time since an arbitrary origin, ns.
    fn now_ns(&self) -> u64;
    /// Calendar time. It advances with [`Clock::now_ns`], whatever happens to the computer's wall clock.
    fn utc(&self) -> Timestamp;
}

/// The computer's monotonic clock; the wall clock is read once, at the start.
pub struct SystemClock {
    origin: Instant,
    date: Timestamp,
}

impl SystemClock {
    /// A clock whose origin is now.
    pub fn start() -> Self {
        Self {
            origin: Instant::now(),
            date: Timestamp::now(),
        }
    }
}

impl Clock for SystemClock {
    fn now_ns(&self) -> u64 {
        u64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn utc(&self) -> Timestamp {
        later(self.date, self.now_ns())
    }
}

/// `date` plus `elapsed_ns`, saturating at the end of the calendar.
pub fn later(date: Timestamp, elapsed_ns: u64) -> Timestamp {
    let elapsed = SignedDuration::from_nanos(i64::try_from(elapsed_ns).unwrap_or(i64::MAX));
    date.saturating_add(elapsed).unwrap_or(Timestamp::MAX)
}
