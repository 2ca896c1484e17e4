//! Limiter: the last check of every voltage before the converter.

use thiserror::Error;

/// Hard limit of the drive, volts peak across the actuators; no configuration can raise it.
///
/// An assumption, because the paper does not specify the piezo discs: the ×20 amplifier of SCIENCE.md section 1 with ±7.5 V at
/// its input, three quarters of a common ±10 V output.
pub const HARD_LIMIT_V: f64 = 150.0;

/// Excess over the limit that counts as rounding, as a factor.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Cause of a trip, which cuts the drive off at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TripCause {
    /// A voltage is not a number, or infinite.
    #[error("drive voltage is not a finite number")]
    NotFinite,
    /// A voltage exceeds the configured limit.
    #[error("drive voltage beyond the configured limit")]
    OverRange,
    /// A program was admitted under settings other than the generator's.
    #[error("program was admitted under other drive settings")]
    ForeignProgram,
}

/// A limit that the limiter rejects.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum LimitError {
    /// The limit exceeds [`HARD_LIMIT_V`].
    #[error(
        "drive limit {limit_v} V peak is above the hard limit of {HARD_LIMIT_V} V peak: lower limit_v"
    )]
    AboveHardLimit {
        /// Requested limit, V peak.
        limit_v: f64,
    },
    /// The limit is zero, negative or not a number.
    #[error("drive limit {limit_v} V peak must be above 0 and at most {HARD_LIMIT_V} V peak")]
    NotPositive {
        /// Requested limit, V peak.
        limit_v: f64,
    },
}

/// Passes only voltages within the configured limit.
///
/// ```
/// use signalgen::{Limiter, TripCause};
///
/// let limiter = Limiter::new(80.0)?;
/// assert_eq!(limiter.check(-79.0), Ok(-79.0));
/// assert_eq!(limiter.check(80.1), Err(TripCause::OverRange));
/// assert_eq!(limiter.check(f64::NAN), Err(TripCause::NotFinite));
/// # Ok::<(), signalgen::LimitError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limiter {
    limit_v: f64,
}

impl Limiter {
    /// Creates a limiter at `limit_v` volts peak.
    ///
    /// # Errors
    /// If the limit is not in 0 < limit ≤ [`HARD_LIMIT_V`]: it is rejected, never clamped.
    pub fn new(limit_v: f64) -> Result<Self, LimitError> {
        if limit_v > HARD_LIMIT_V {
            Err(LimitError::AboveHardLimit { limit_v })
        } else if limit_v > 0.0 {
            Ok(Self { limit_v })
        } else {
            Err(LimitError::NotPositive { limit_v })
        }
    }

    /// Returns the configured limit, V peak.
    #[must_use]
    pub fn limit_v(&self) -> f64 {
        self.limit_v
    }

    /// Returns `volts` if they are within the limit.
    ///
    /// # Errors
    /// If they are not: the caller must output zero and latch. An excess below 1e-9 of the limit counts as rounding and passes.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_up_to_the_hard_limit_are_accepted() {
        for limit_v in [1e-3, 80.0, HARD_LIMIT_V] {
            assert_eq!(Limiter::new(limit_v).map(|l| l.limit_v()), Ok(limit_v));
        }
    }

    /// Fault 14.
    /// Hazard 1.
    #[test]
    fn limits_above_the_hard_limit_are_rejected_with_both_values() {
        for limit_v in [150.000_001, 800.0, f64::INFINITY] {
            let error = Limiter::new(limit_v).unwrap_err();
            assert_eq!(error, LimitError::AboveHardLimit { limit_v });
            let message = error.to_string();
            assert!(message.contains(&limit_v.to_string()), "{message}");
            assert!(message.contains("150 V"), "{message}");
        }
    }

    #[test]
    fn invalid_limits_are_rejected() {
        for limit_v in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(matches!(
                Limiter::new(limit_v),
                Err(LimitError::NotPositive { .. })
            ));
        }
    }

    /// Hazard 1.
    #[test]
    fn only_voltages_within_the_limit_pass() {
        let limiter = Limiter::new(80.0).unwrap();
        for volts in [0.0, -80.0, 80.0, 80.0 * (1.0 + 1e-15)] {
            assert_eq!(limiter.check(volts), Ok(volts));
        }
        for volts in [80.001, -80.001, f64::MAX] {
            assert_eq!(limiter.check(volts), Err(TripCause::OverRange));
        }
        for volts in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(limiter.check(volts), Err(TripCause::NotFinite));
        }
    }
}
