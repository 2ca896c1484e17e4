//! The last word on the drive voltage.

use thiserror::Error;

/// Hard limit of the drive, volts peak across the actuators: no configuration raises it.
///
/// An assumption, for the piezo discs are not specified in the paper: the ×20 amplifier of
/// SCIENCE.md section 1 fed with ±7.5 V, three quarters of a common ±10 V output.
pub const HARD_LIMIT_V: f64 = 150.0;

/// Excess over the limit that counts as rounding.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Why the limiter cut the drive off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TripCause {
    /// A voltage that is no number, or infinite.
    #[error("drive voltage is not a finite number")]
    NotFinite,
    /// A voltage beyond the configured limit.
    #[error("drive voltage beyond the configured limit")]
    OverRange,
    /// A program admitted under other settings than the generator's.
    #[error("program was admitted under other drive settings")]
    ForeignProgram,
}

/// A limit that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum LimitError {
    /// Beyond the compiled-in limit.
    #[error(
        "drive limit {limit_v} V peak is above the hard limit of {HARD_LIMIT_V} V peak: lower limit_v"
    )]
    AboveHardLimit {
        /// The limit asked for, V peak.
        limit_v: f64,
    },
    /// Zero, negative or no number.
    #[error("drive limit {limit_v} V peak must be above 0 and at most {HARD_LIMIT_V} V peak")]
    NotPositive {
        /// The limit asked for, V peak.
        limit_v: f64,
    },
}

/// Passes voltages within the configured limit, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limiter {
    limit_v: f64,
}

impl Limiter {
    /// A limiter at `limit_v` volts peak.
    ///
    /// # Errors
    /// If the limit is not in 0 < limit ≤ [`HARD_LIMIT_V`]. It is rejected, never clamped.
    pub fn new(limit_v: f64) -> Result<Self, LimitError> {
        if limit_v > HARD_LIMIT_V {
            Err(LimitError::AboveHardLimit { limit_v })
        } else if limit_v > 0.0 {
            Ok(Self { limit_v })
        } else {
            Err(LimitError::NotPositive { limit_v })
        }
    }

    /// The configured limit, V peak.
    #[must_use]
    pub fn limit_v(&self) -> f64 {
        self.limit_v
    }

    /// Whether `volts` may go out.
    ///
    /// # Errors
    /// If it may not; the caller puts out zero and latches. An excess below 1e-9 of the limit is
    /// rounding and passes.
    #[inline]
    pub fn check(&self, volts: f64) -> Result<f64, TripCause> {
        if volts.abs() <= self.limit_v * ROUNDING {
            Ok(volts)
        } else if volts.is_finite() {
            Err(TripCause::OverRange)
        } else {
            Err(TripCause::NotFinite)
        }
    }
}
