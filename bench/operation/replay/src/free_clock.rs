//! Clock of a replay that runs as fast as possible.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jiff::Timestamp;
use tasks::{Clock, Pacer, later};

/// Length of recording read per tick at full speed, ns.
const TICK_NS: u64 = 10_000_000;

/// A clock that advances only when ticked.
#[derive(Debug, Default)]
pub(super) struct FreeClock(AtomicU64);

impl Clock for FreeClock {
    fn now_ns(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    /// A replay records no dates.
    fn utc(&self) -> Timestamp {
        later(Timestamp::UNIX_EPOCH, self.now_ns())
    }
}

/// Advances a [`FreeClock`] by a fixed length of recording per tick.
pub(super) struct Ticks(pub(super) Arc<FreeClock>);

impl Pacer for Ticks {
    fn tick(&mut self) -> anyhow::Result<()> {
        self.0.0.fetch_add(TICK_NS, Ordering::Relaxed);
        Ok(())
    }
}
