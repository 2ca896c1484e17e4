//! The date before a bench is opened.

use config::Effective;
use jiff::Timestamp;
use safety::Pace;
use tasks::{Clock, SystemClock};

/// Returns the present date by the computer's clock.
#[must_use]
pub fn now() -> Timestamp {
    SystemClock::start().utc()
}

/// Returns what nobody has measured on this bench although its safety rests on it; nothing where no finger lies.
#[must_use]
pub fn unverified(bench: &Effective, pace: Pace) -> Vec<String> {
    match pace {
        Pace::Card => bench.unverified(now()),
        Pace::Simulated => Vec::new(),
    }
}
