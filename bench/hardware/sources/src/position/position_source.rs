//! Trait of all position sources.

use crate::force_source::SourceHealth;
use crate::loss::SourceGone;

/// Rate at which positions are delivered, Hz.
pub const POSITION_HZ: f64 = 1e3;

/// An encoder count with its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counted {
    /// Time on the host's clock, s.
    pub host_s: f64,
    /// Time on the clock of the encoder's device, s: it always advances between counts, whereas the estimate of host time may
    /// not.
    pub source_s: f64,
    /// Quadrature counts since the first reading.
    pub count: i64,
    /// Encoder states missed so far, as far as the source can detect them.
    pub missed: u64,
    /// Whether the counter has restarted since the first reading, so that its origin is unknown.
    pub lost: bool,
}

/// A source of positions. A silent source passes no positions.
pub trait PositionSource: Send {
    /// Reads without waiting the counts that have arrived, and passes positions to `take` at [`POSITION_HZ`] at most; the poll
    /// is at `now_ns`, and `now_s` returns the host's time, s.
    ///
    /// # Errors
    /// [`SourceGone`] if the source no longer exists.
    fn poll(
        &mut self,
        now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Counted),
    ) -> Result<(), SourceGone>;

    /// Returns the state of a source that has its own clock.
    fn health(&self) -> SourceHealth {
        SourceHealth::default()
    }
}
