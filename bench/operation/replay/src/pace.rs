//! Speed at which a recording is read.

use std::time::{Duration, Instant};

/// Length read and the time it took, without pauses and the wait at the end; repeated reading after seeking back counts again.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    last_look: Option<Instant>,
    /// Time spent reading.
    reading_time: Duration,
    /// Length read, s of the recording.
    pub(crate) read_s: f64,
}

impl Pace {
    /// Adds the time since the last call, if the recording was being read.
    pub(crate) fn pass(&mut self, reading: bool) {
        let now = Instant::now();
        let elapsed = now - self.last_look.replace(now).unwrap_or(now);
        if reading {
            self.reading_time += elapsed;
        }
    }

    /// Returns the time spent reading, s.
    pub(crate) fn took_s(&self) -> f64 {
        self.reading_time.as_secs_f64()
    }
}
