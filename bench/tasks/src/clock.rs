//! Time on the host: monotonic nanoseconds, and a calendar date that cannot jump while the program runs.

use std::time::Instant;

use jiff::{SignedDuration, Timestamp};

/// Source of time for the bench. Everything that stamps an arrival or writes a date uses it, so that a simulated
/// apparatus can supply its own time and the same run gives the same files.
pub trait Clock: Send + Sync {
    /// Returns the monotonic time since an arbitrary origin, ns.
    fn now_ns(&self) -> u64;
    /// Returns the calendar time, which advances with [`Clock::now_ns`] whatever happens to the computer's wall clock.
    fn utc(&self) -> Timestamp;
    /// Returns whether the calendar time is made up by a simulation that runs free.
    fn is_simulated(&self) -> bool {
        false
    }
}

/// Clock of the computer: its monotonic clock, and the date of its wall clock as read once, at the start.
pub struct SystemClock {
    origin: Instant,
    date: Timestamp,
}

impl SystemClock {
    /// Starts a clock whose origin is now.
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

/// Returns `date` plus `elapsed_ns`, saturating at the end of the calendar.
pub fn later(date: Timestamp, elapsed_ns: u64) -> Timestamp {
    let elapsed = SignedDuration::from_nanos(i64::try_from(elapsed_ns).unwrap_or(i64::MAX));
    date.saturating_add(elapsed).unwrap_or(Timestamp::MAX)
}
