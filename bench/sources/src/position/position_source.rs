//! The trait of all sources of positions.

use crate::force_source::SourceHealth;
use crate::gone::SourceGone;

/// Rate at which positions are passed on, Hz.
pub const POSITION_HZ: f64 = 1e3;

/// A count of an encoder, and when it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counted {
    /// Time on the host's clock, s.
    pub host_s: f64,
    /// Time on the clock that the encoder is read by, s: it advances from one count to the next, as the estimate of host
    /// time need not.
    pub own_s: f64,
    /// Quadrature counts since the first reading.
    pub count: i64,
    /// Encoder states missed so far, as far as the source can tell.
    pub missed: u64,
    /// Whether the counter has begun anew since the first reading: where it counts from is unknown.
    pub lost: bool,
}

/// A source of positions. One that is silent passes none.
pub trait PositionSource: Send {
    /// Counts what has come, without waiting, and passes positions to `take`, [`POSITION_HZ`] at most; the poll is at
    /// `now_ns`, and `now_s` is the host's clock, s.
    ///
    /// # Errors
    /// [`SourceGone`] when there is nothing left to read from.
    fn poll(
        &mut self,
        now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Counted),
    ) -> Result<(), SourceGone>;

    /// Returns how a source with a clock of its own fares.
    fn health(&self) -> SourceHealth {
        SourceHealth::default()
    }
}
