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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_up_to_the_hard_limit_are_accepted() {
        for limit_v in [1e-3, 80.0, HARD_LIMIT_V] {
            assert_eq!(Limiter::new(limit_v).map(|l| l.limit_v()), Ok(limit_v));
        }
    }

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
    fn limits_that_are_no_limits_are_rejected() {
        for limit_v in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(matches!(
                Limiter::new(limit_v),
                Err(LimitError::NotPositive { .. })
            ));
        }
    }

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
