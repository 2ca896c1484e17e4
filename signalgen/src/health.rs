//! What the streams report about themselves: xruns, faults, age of the last callback.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use thiserror::Error;

/// What a stream's error callback reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StreamFault {
    /// A buffer under- or overrun: frames were lost.
    #[error("buffer under- or overrun")]
    Xrun,
    /// The device or its server went away.
    #[error("device or audio server no longer available")]
    DeviceLost,
    /// The stream is no longer valid and must be opened anew.
    #[error("stream no longer valid")]
    Invalidated,
    /// The system routed the stream to another device.
    #[error("stream rerouted to another device")]
    Rerouted,
    /// Real-time scheduling was refused; the stream goes on.
    #[error("real-time scheduling refused")]
    RealtimeDenied,
    /// Anything else.
    #[error("audio backend error")]
    Backend,
}

const FAULTS: [StreamFault; 6] = [
    StreamFault::Xrun,
    StreamFault::DeviceLost,
    StreamFault::Invalidated,
    StreamFault::Rerouted,
    StreamFault::RealtimeDenied,
    StreamFault::Backend,
];

/// No callback or fault yet.
const NEVER: u64 = u64::MAX;

/// Direction of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// To the converter.
    Output,
    /// From the converter.
    Input,
}

impl std::fmt::Display for Direction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Output => "output",
            Self::Input => "input",
        })
    }
}

#[derive(Debug)]
struct Counters {
    callbacks: AtomicU64,
    last_callback_ns: AtomicU64,
    xruns: AtomicU64,
    /// Index into [`FAULTS`] plus one; 0 for none.
    last_fault: AtomicU8,
    lost: AtomicBool,
}

impl Counters {
    fn new() -> Self {
        Self {
            callbacks: AtomicU64::new(0),
            last_callback_ns: AtomicU64::new(NEVER),
            xruns: AtomicU64::new(0),
            last_fault: AtomicU8::new(0),
            lost: AtomicBool::new(false),
        }
    }
}

#[derive(Debug)]
struct Shared {
    epoch: Instant,
    output: Counters,
    input: Counters,
}

/// Counters of both directions, written by the callbacks and read by anyone; lock-free.
#[derive(Clone, Debug)]
pub struct Health(Arc<Shared>);

/// One direction's counters at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionHealth {
    /// Callbacks so far.
    pub callbacks: u64,
    /// Age of the last callback on the monotonic clock; `None` before the first.
    pub callback_age: Option<Duration>,
    /// Xruns reported so far. How many frames each lost is not reported by any backend.
    pub xruns: u64,
    /// The last fault reported.
    pub last_fault: Option<StreamFault>,
    /// Whether the device was lost or the stream invalidated: it will not call back again.
    pub device_lost: bool,
}

impl Health {
    pub(crate) fn new() -> Self {
        Self(Arc::new(Shared {
            epoch: Instant::now(),
            output: Counters::new(),
            input: Counters::new(),
        }))
    }

    /// Counters of one direction.
    #[must_use]
    pub fn read(&self, direction: Direction) -> DirectionHealth {
        let counters = self.counters(direction);
        let last_ns = counters.last_callback_ns.load(Ordering::Acquire);
        let fault = counters.last_fault.load(Ordering::Acquire);
        DirectionHealth {
            callbacks: counters.callbacks.load(Ordering::Relaxed),
            callback_age: (last_ns != NEVER)
                .then(|| Duration::from_nanos(self.now_ns().saturating_sub(last_ns))),
            xruns: counters.xruns.load(Ordering::Acquire),
            last_fault: fault
                .checked_sub(1)
                .map(|index| FAULTS[usize::from(index) % FAULTS.len()]),
            device_lost: counters.lost.load(Ordering::Acquire),
        }
    }

    /// Nanoseconds of the monotonic clock since the streams were opened: the clock of
    /// [`crate::BlockHeader::arrived_ns`].
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        u64::try_from(self.0.epoch.elapsed().as_nanos()).unwrap_or(NEVER - 1)
    }

    pub(crate) fn xruns(&self, direction: Direction) -> u64 {
        self.counters(direction).xruns.load(Ordering::Acquire)
    }

    /// Called by the data callbacks; returns the time of the callback.
    pub(crate) fn beat(&self, direction: Direction) -> u64 {
        let now_ns = self.now_ns();
        let counters = self.counters(direction);
        counters.last_callback_ns.store(now_ns, Ordering::Release);
        counters.callbacks.fetch_add(1, Ordering::Relaxed);
        now_ns
    }

    /// Called by the error callbacks.
    pub(crate) fn report(&self, direction: Direction, fault: StreamFault) {
        let counters = self.counters(direction);
        match fault {
            StreamFault::Xrun => {
                counters.xruns.fetch_add(1, Ordering::AcqRel);
            }
            StreamFault::DeviceLost | StreamFault::Invalidated => {
                counters.lost.store(true, Ordering::Release);
            }
            StreamFault::Rerouted | StreamFault::RealtimeDenied | StreamFault::Backend => {}
        }
        let code = 1 + FAULTS.iter().position(|&known| known == fault).unwrap_or(0);
        counters.last_fault.store(code as u8, Ordering::Release);
    }

    fn counters(&self, direction: Direction) -> &Counters {
        match direction {
            Direction::Output => &self.0.output,
            Direction::Input => &self.0.input,
        }
    }
}
