//! Time on the host: monotonic nanoseconds, and a calendar date that cannot jump while the program runs.

use std::time::Instant;

use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};

/// Source of time for the bench. All code that stamps an arrival or writes a date uses it, so that a simulated
/// apparatus can supply its own time and the same run gives the same files.
pub trait Clock: Send + Sync {
    /// Returns the monotonic time since an arbitrary origin, ns; on Linux and macOS it stands still while the computer
    /// is suspended.
    fn now_ns(&self) -> u64;
    /// Returns the time for which the computer has been suspended since the origin, ns, as far as [`Clock::now_ns`]
    /// does not count it; 0 if the system does not say, as on all systems but Linux.
    fn suspended_ns(&self) -> u64 {
        0
    }
    /// Returns the calendar time, which advances with [`Clock::now_ns`] and with suspensions, independently of the
    /// computer's wall clock.
    fn utc(&self) -> Timestamp;
    /// Returns whether the calendar time comes from a free-running simulation.
    fn is_simulated(&self) -> bool {
        false
    }
    /// Returns the laboratory's day, as `2026-01-31`; that of UTC on a free-running simulation, so that the same run gives
    /// the same files everywhere.
    fn day(&self) -> String {
        if self.is_simulated() {
            calendar::day_in(self.utc(), TimeZone::UTC)
        } else {
            calendar::day(self.utc())
        }
    }
    /// Returns the time since the origin, s, suspensions included: the clock for records that outlast the program.
    fn since_origin_s(&self) -> f64 {
        self.now_ns().saturating_add(self.suspended_ns()) as f64 * 1e-9
    }
}

/// Most readings of the two clocks from which the best is taken.
const READINGS: usize = 5;

/// Longest time between two readings of the monotonic clock for which a reading of the other is simultaneous, ns.
const APART_NS: u64 = 1_000_000;

/// Clock of the computer: its monotonic clock, and the date of its wall clock read once, at the start.
pub struct SystemClock {
    origin: Instant,
    /// Origin on the clock that counts suspensions, ns; `None` if there is no clock other than [`Instant`]'s.
    origin_ns: Option<u64>,
    date: Timestamp,
}

impl SystemClock {
    /// Starts a clock with its origin now.
    pub fn start() -> Self {
        Self {
            origin: Instant::now(),
            origin_ns: boot_ns(),
            date: Timestamp::now(),
        }
    }

    /// Returns the time since the origin, ns, suspensions included where the system counts them.
    fn passed_ns(&self) -> u64 {
        match (boot_ns(), self.origin_ns) {
            (Some(now_ns), Some(origin_ns)) => now_ns.saturating_sub(origin_ns),
            _ => self.now_ns(),
        }
    }
}

impl Clock for SystemClock {
    fn now_ns(&self) -> u64 {
        u64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn suspended_ns(&self) -> u64 {
        // A pause between the two clocks counts as a suspension: of several readings, the one with the shortest pause
        // is taken.
        let readings = (0..READINGS).map(|_| {
            let now_ns = self.now_ns();
            let suspended_ns = self.passed_ns().saturating_sub(now_ns);
            (self.now_ns() - now_ns, suspended_ns)
        });
        let mut shortest = (u64::MAX, 0);
        for reading in readings {
            shortest = shortest.min(reading);
            if shortest.0 < APART_NS {
                break;
            }
        }
        shortest.1
    }

    fn utc(&self) -> Timestamp {
        later(self.date, self.passed_ns())
    }
}

/// Returns the time since the computer was started, ns, suspensions included.
#[cfg(target_os = "linux")]
fn boot_ns() -> Option<u64> {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::Boottime);
    let (seconds, ns) = (u64::try_from(time.tv_sec), u64::try_from(time.tv_nsec));
    Some(seconds.ok()? * 1_000_000_000 + ns.ok()?)
}

/// Returns `None`: [`Instant`] is the only clock that is read.
#[cfg(not(target_os = "linux"))]
fn boot_ns() -> Option<u64> {
    None
}

/// Returns `date` plus `elapsed_ns`, saturating at the end of the calendar.
pub fn later(date: Timestamp, elapsed_ns: u64) -> Timestamp {
    let elapsed = SignedDuration::from_nanos(i64::try_from(elapsed_ns).unwrap_or(i64::MAX));
    date.saturating_add(elapsed).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    /// Clock after a suspension of the computer for an hour: its origin is that much longer ago on the clock that
    /// counts suspensions.
    /// Fault 39.
    #[test]
    fn a_date_goes_on_through_a_suspension_and_the_monotonic_clock_does_not() {
        const HOUR_NS: u64 = 3_600_000_000_000;
        let clock = SystemClock {
            origin_ns: Some(0),
            ..SystemClock::start()
        };
        let suspended_ns = clock.suspended_ns();
        let later_ns = boot_ns().unwrap();
        assert!(suspended_ns <= later_ns && clock.now_ns() < HOUR_NS);
        let elapsed = Clock::utc(&clock).duration_since(clock.date);
        assert!(elapsed.as_nanos() >= i128::from(suspended_ns));
        assert!((clock.since_origin_s() - 1e-9 * later_ns as f64).abs() < 60.0);
        let awake = SystemClock::start();
        assert!(awake.suspended_ns() < HOUR_NS);
    }
}
