//! A clock and a run of the computer that tests set.

use std::sync::atomic::{AtomicU64, Ordering};

use jiff::Timestamp;
use tasks::Clock;

use crate::boot::Boot;

/// Clock set by the test, with the time for which the computer was suspended, s; its date is its time.
#[derive(Default)]
pub(crate) struct Hands(pub AtomicU64, pub AtomicU64);

impl Clock for Hands {
    fn now_ns(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn suspended_ns(&self) -> u64 {
        1_000_000_000 * self.1.load(Ordering::Relaxed)
    }

    fn utc(&self) -> Timestamp {
        let passed_ns = self.now_ns() + self.suspended_ns();
        Timestamp::from_nanosecond(i128::from(passed_ns)).unwrap()
    }
}

/// Returns the run of a computer that has been on for `up_s`.
pub(crate) fn boot(up_s: f64) -> Boot {
    Boot {
        id: Some("abc".to_owned()),
        up_s,
        machine: Some("1".to_owned()),
    }
}
