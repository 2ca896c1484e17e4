//! Scheduling of the sound card's callbacks, as their threads found it.

use std::sync::OnceLock;

use signalgen::StreamDirection;
use tasks::scheduling::Scheduling;

/// Scheduling of the threads of both streams, once they have started.
#[derive(Debug, Default)]
pub struct StreamThreads {
    output: OnceLock<Scheduling>,
    input: OnceLock<Scheduling>,
}

impl StreamThreads {
    /// Returns the scheduling of a stream; `None` before its first block, or if it was not queried.
    #[must_use]
    pub fn get(&self, direction: StreamDirection) -> Option<Scheduling> {
        self.thread(direction).get().copied()
    }

    /// Keeps the scheduling of a stream. Neither allocates nor waits: each stream has one thread.
    pub(crate) fn started(&self, direction: StreamDirection, scheduling: Scheduling) {
        let _ = self.thread(direction).set(scheduling);
    }

    fn thread(&self, direction: StreamDirection) -> &OnceLock<Scheduling> {
        match direction {
            StreamDirection::Output => &self.output,
            StreamDirection::Input => &self.input,
        }
    }
}
