//! Observations of the bench, and orders to it.

use safety::SafetyState;

/// Observation of the bench at one moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<'a> {
    /// Time on a monotonic clock, s.
    pub now_s: f64,
    /// State of the safety watch.
    pub safety: &'a SafetyState,
    /// Whether the plate is driven, ramps included.
    pub sounds: bool,
    /// Flag raised by the bench since the fault began.
    pub flag: Option<&'a str>,
}

/// An order of the exercise to the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Drive.
    Drive,
    /// Stop in an orderly way.
    Pause,
    /// Stop at once, at the operator's request.
    Stop,
    /// Inject the fault.
    Begin,
    /// Remove the cause of the fault.
    End,
    /// Release the latch.
    Rearm,
}
