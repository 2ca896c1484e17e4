//! Health of the two streams: xruns, faults, and age of the latest callback.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use thiserror::Error;

/// A fault reported by a stream's error callback.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StreamFault {
    /// A buffer under- or overrun: frames were lost.
    #[error("buffer under- or overrun")]
    Xrun,
    /// The device or its server has gone.
    #[error("device or audio server no longer available")]
    DeviceLost,
    /// The stream is no longer valid and must be reopened.
    #[error("stream no longer valid")]
    Invalidated,
    /// The system routed the stream to another device.
    #[error("stream rerouted to another device")]
    Rerouted,
    /// Real-time scheduling was refused; the stream continues.
    #[error("real-time scheduling refused")]
    RealtimeDenied,
    /// Any other error of the backend.
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

/// Time of the latest callback before the first one.
const NO_CALLBACK: u64 = u64::MAX;

/// Direction of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StreamDirection {
    /// Samples go to the converter.
    Output,
    /// Samples come from the converter.
    Input,
}

impl std::fmt::Display for StreamDirection {
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
    /// Index into [`FAULTS`] plus one; 0 for no fault.
    last_fault: AtomicU8,
    lost: AtomicBool,
}

impl Counters {
    fn new() -> Self {
        Self {
            callbacks: AtomicU64::new(0),
            last_callback_ns: AtomicU64::new(NO_CALLBACK),
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

/// Counters of both directions, written by the callbacks and read from any thread; lock-free.
///
/// Clones share the counters.
///
/// ```
/// use signalgen::{StreamDirection, StreamFault, StreamHealth};
///
/// let health = StreamHealth::new();
/// health.report(StreamDirection::Input, StreamFault::Xrun);
/// let input = health.read(StreamDirection::Input);
/// assert_eq!((input.xruns, input.last_fault), (1, Some(StreamFault::Xrun)));
/// assert_eq!(health.read(StreamDirection::Output).xruns, 0);
/// ```
#[derive(Clone, Debug)]
pub struct StreamHealth(Arc<Shared>);

/// Counters of one direction at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionHealth {
    /// Number of callbacks so far.
    pub callbacks: u64,
    /// Age of the latest callback on the monotonic clock; `None` before the first.
    pub callback_age: Option<Duration>,
    /// Number of reported xruns. Backends do not report how many frames each lost.
    pub xruns: u64,
    /// Latest reported fault.
    pub last_fault: Option<StreamFault>,
    /// Whether the device was lost or the stream invalidated; no further callbacks will come.
    pub device_lost: bool,
}

impl Default for StreamHealth {
    fn default() -> Self {
        Self::new()
    }
}

impl StreamHealth {
    /// Starts both directions' counters at 0, and the clock of [`Self::now_ns`].
    #[must_use]
    pub fn new() -> Self {
        Self(Arc::new(Shared {
            epoch: Instant::now(),
            output: Counters::new(),
            input: Counters::new(),
        }))
    }

    /// Returns the counters of one direction.
    #[must_use]
    pub fn read(&self, direction: StreamDirection) -> DirectionHealth {
        let counters = self.counters(direction);
        let last_ns = counters.last_callback_ns.load(Ordering::Acquire);
        let fault = counters.last_fault.load(Ordering::Acquire);
        DirectionHealth {
            callbacks: counters.callbacks.load(Ordering::Relaxed),
            callback_age: (last_ns != NO_CALLBACK)
                .then(|| Duration::from_nanos(self.now_ns().saturating_sub(last_ns))),
            xruns: counters.xruns.load(Ordering::Acquire),
            last_fault: fault
                .checked_sub(1)
                .map(|index| FAULTS[usize::from(index) % FAULTS.len()]),
            device_lost: counters.lost.load(Ordering::Acquire),
        }
    }

    /// Returns the time on the monotonic clock since these counters were created, ns, which is before the streams were opened:
    /// the clock of [`crate::BlockHeader::arrived_ns`].
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        u64::try_from(self.0.epoch.elapsed().as_nanos()).unwrap_or(NO_CALLBACK - 1)
    }

    /// Returns the number of xruns of one direction so far.
    pub(crate) fn xruns(&self, direction: StreamDirection) -> u64 {
        self.counters(direction).xruns.load(Ordering::Acquire)
    }

    /// Counts a data callback; returns its time on the clock of [`Self::now_ns`].
    pub(crate) fn beat(&self, direction: StreamDirection) -> u64 {
        let now_ns = self.now_ns();
        let counters = self.counters(direction);
        counters.last_callback_ns.store(now_ns, Ordering::Release);
        counters.callbacks.fetch_add(1, Ordering::Relaxed);
        now_ns
    }

    /// Counts a fault that a stream's error callback received. Neither allocates nor blocks.
    pub fn report(&self, direction: StreamDirection, fault: StreamFault) {
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
        let code = 1 + FAULTS
            .iter()
            .position(|&listed| listed == fault)
            .unwrap_or(0);
        counters.last_fault.store(code as u8, Ordering::Release);
    }

    fn counters(&self, direction: StreamDirection) -> &Counters {
        match direction {
            StreamDirection::Output => &self.0.output,
            StreamDirection::Input => &self.0.input,
        }
    }
}
