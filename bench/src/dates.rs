//! The date, before a bench is opened.

use config::Effective;
use jiff::Timestamp;
use safety::Pace;
use tasks::{Clock, SystemClock};

/// Returns the present date by the computer's clock.
#[must_use]
pub fn now() -> Timestamp {
    SystemClock::start().utc()
}

/// Returns the safety-relevant measurements that are missing or outdated, a line each; empty on simulated hardware, which
/// no finger touches.
#[must_use]
pub fn unverified(bench: &Effective, pace: Pace) -> Vec<String> {
    match pace {
        Pace::Card => bench.unverified(now()),
        Pace::Simulated => Vec::new(),
    }
}
