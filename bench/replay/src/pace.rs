//! How fast a recording is read.

use std::time::{Duration, Instant};

/// Length of what is read, and the time that it takes: pauses and the wait at the end are left out, what is read again after
/// moving back is counted again.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    looked: Option<Instant>,
    /// Time for which it was read.
    took: Duration,
    /// Length of what was read, s of the recording.
    pub(crate) read_s: f64,
}

impl Pace {
    /// Takes the time since the last look as one in which the recording was read, or not.
    pub(crate) fn pass(&mut self, reading: bool) {
        let now = Instant::now();
        let passed = now - self.looked.replace(now).unwrap_or(now);
        if reading {
            self.took += passed;
        }
    }

    /// Returns the time for which it was read, s.
    pub(crate) fn took_s(&self) -> f64 {
        self.took.as_secs_f64()
    }
}
