//! Number of samples lost in an overrun, from the phase of the drive channel.

use crate::carrier_phase::CarrierPhase;
use statistics::wrap_rad;
use statistics::{significant, with_error};
use std::f64::consts::PI;

/// Jump of the drive envelope's phase across the loss, when demodulated without accounting for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseJump {
    /// Phase after the loss minus phase before, rad.
    pub jump_rad: f64,
    /// Largest error of `jump_rad`, rad.
    pub tolerance_rad: f64,
}

/// Number of missing frames according to the timestamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimestampEstimate {
    /// Best estimate, frames.
    pub frames: f64,
    /// Largest error of `frames`, frames.
    pub uncertainty_frames: f64,
}

/// Reasons why phase and timestamps do not determine the number of lost frames.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SampleLossError {
    /// More than one number of frames is consistent with both.
    #[error(
        "{first} and {second} lost frames both explain a phase jump of {} rad",
        with_error(*.jump_rad, *.tolerance_rad, 3)
    )]
    Ambiguous {
        /// The smallest number that fits.
        first: u64,
        /// The next number that fits.
        second: u64,
        /// Phase jump, rad.
        jump_rad: f64,
        /// Largest error of the jump, rad.
        tolerance_rad: f64,
    },
    /// No number of frames is consistent with both: the drive itself has jumped, or an estimate is wrong.
    #[error(
        "no loss of {lowest} to {highest} frames explains a phase jump of {} rad; the nearest is off by {} rad",
        with_error(*.jump_rad, *.tolerance_rad, 3), significant(*.nearest_rad)
    )]
    Unexplained {
        /// Smallest number of frames consistent with the timestamps.
        lowest: u64,
        /// Largest number of frames consistent with the timestamps.
        highest: u64,
        /// Phase jump, rad.
        jump_rad: f64,
        /// Largest error of the jump, rad.
        tolerance_rad: f64,
        /// Smallest difference from the jump over all numbers of frames, rad.
        nearest_rad: f64,
    },
    /// An argument is not finite, or negative although it must not be.
    #[error("{name} is {value}, but must be finite{}", if *.non_negative { " and not negative" } else { "" })]
    Input {
        /// Name of the argument.
        name: &'static str,
        /// Value of the argument.
        value: f64,
        /// Whether the argument must not be negative.
        non_negative: bool,
    },
    /// The timestamps leave a range of frames too wide for the carrier's phase to resolve.
    #[error("timestamps leave {span} frames open, more than the limit of {MOST_CANDIDATES}")]
    TooVague {
        /// Width of that range, frames.
        span: f64,
    },
}

/// Largest number of candidates tried: one minute at 192 kHz.
const MOST_CANDIDATES: u64 = 60 * 192_000;

/// Returns the exact number k of frames lost at the converter's input. k lost frames rotate the envelope's phase by
/// 2π·k·carrier/rate, which determines k modulo the carrier's period; the timestamps determine the multiple: after the loss
/// sample n is that of n + k, and cos(ω(n + k)/rate) demodulated with e^{−iωn/rate} has the phase +ωk/rate.
///
/// ```
/// use impedance::sample_loss::{PhaseJump, TimestampEstimate, lost_frames};
/// use std::f64::consts::TAU;
///
/// // Timestamps say about 1000 frames, give or take 90; at 35 kHz and 192 kHz the phase repeats every 192.
/// let jump = PhaseJump {
///     jump_rad: (TAU * 35.0 / 192.0 * 1024.0) % TAU,
///     tolerance_rad: 0.01,
/// };
/// let estimate = TimestampEstimate { frames: 1000.0, uncertainty_frames: 90.0 };
/// assert_eq!(lost_frames(35e3, 192_000, jump, estimate), Ok(1024));
/// ```
///
/// # Errors
/// When more than one k or no k is consistent with both; when an input is not finite or a tolerance is negative.
pub fn lost_frames(
    carrier_hz: f64,
    sample_rate_hz: u32,
    jump: PhaseJump,
    estimate: TimestampEstimate,
) -> Result<u64, SampleLossError> {
    let PhaseJump {
        jump_rad,
        tolerance_rad,
    } = jump;
    let TimestampEstimate {
        frames,
        uncertainty_frames,
    } = estimate;
    for (name, value, non_negative) in [
        ("carrier_hz", carrier_hz, true),
        ("jump_rad", jump_rad, false),
        ("tolerance_rad", tolerance_rad, true),
        ("frames", frames, false),
        ("uncertainty_frames", uncertainty_frames, true),
    ] {
        if !value.is_finite() || (non_negative && value < 0.0) {
            return Err(SampleLossError::Input {
                name,
                value,
                non_negative,
            });
        }
    }
    let lowest = (frames - uncertainty_frames).ceil().max(0.0) as u64;
    let highest = (frames + uncertainty_frames).floor().max(0.0) as u64;
    if highest.saturating_sub(lowest) > MOST_CANDIDATES {
        return Err(SampleLossError::TooVague {
            span: 2.0 * uncertainty_frames,
        });
    }

    let phase = CarrierPhase::new(carrier_hz, f64::from(sample_rate_hz));
    let mut nearest_rad = PI;
    let mut fitting = (lowest..=highest).filter(|&k| {
        let residual_rad = wrap_rad(jump_rad - phase.rotation_at(k).arg()).abs();
        nearest_rad = nearest_rad.min(residual_rad);
        residual_rad <= tolerance_rad
    });
    match (fitting.next(), fitting.next()) {
        (Some(first), Some(second)) => Err(SampleLossError::Ambiguous {
            first,
            second,
            jump_rad,
            tolerance_rad,
        }),
        (Some(only), None) => Ok(only),
        (None, _) => Err(SampleLossError::Unexplained {
            lowest,
            highest,
            jump_rad,
            tolerance_rad,
            nearest_rad,
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use proptest::prelude::*;

    fn phase_jump_rad(carrier_hz: f64, rate: u32, k: u64) -> f64 {
        wrap_rad(TAU * (carrier_hz * k as f64 / f64::from(rate)).fract())
    }

    proptest! {
        /// Fault 6.
        #[test]
        fn the_number_lost_is_exact(
            (rate, period) in prop_oneof![Just((192_000u32, 192u64)), Just((96_000, 96)), Just((100_000, 20))],
            lost in 0u64..2_000_000,
            error in -0.45f64..0.45,
            noise in -0.4f64..0.4,
        ) {
            // At 35 kHz the phases of one period are 2π/period apart.
            let spacing = TAU / period as f64;
            let jump = PhaseJump { jump_rad: phase_jump_rad(35_000.0, rate, lost) + noise * spacing, tolerance_rad: 0.45 * spacing };
            let estimate = TimestampEstimate { frames: lost as f64 + error * period as f64, uncertainty_frames: 0.49 * period as f64 };
            prop_assert_eq!(lost_frames(35_000.0, rate, jump, estimate), Ok(lost));
        }

        #[test]
        fn timestamps_that_span_a_period_are_ambiguous(lost in 200u64..2_000_000) {
            let jump = PhaseJump { jump_rad: phase_jump_rad(35_000.0, 192_000, lost), tolerance_rad: 0.01 };
            let estimate = TimestampEstimate { frames: lost as f64, uncertainty_frames: 192.0 };
            let ambiguous = matches!(lost_frames(35_000.0, 192_000, jump, estimate), Err(SampleLossError::Ambiguous { .. }));
            prop_assert!(ambiguous);
        }

        #[test]
        fn a_detuned_carrier_is_followed(lost in 0u64..1_000_000) {
            let jump = PhaseJump { jump_rad: phase_jump_rad(35_012.7, 192_000, lost), tolerance_rad: 1e-4 };
            let estimate = TimestampEstimate { frames: lost as f64 + 5.0, uncertainty_frames: 300.0 };
            prop_assert_eq!(lost_frames(35_012.7, 192_000, jump, estimate), Ok(lost));
        }
    }

    #[test]
    fn a_jump_of_the_drive_itself_is_not_taken_for_a_loss() {
        let jump = PhaseJump {
            jump_rad: 0.016,
            tolerance_rad: 0.005,
        };
        let estimate = TimestampEstimate {
            frames: 100.0,
            uncertainty_frames: 90.0,
        };
        let error = lost_frames(35_000.0, 192_000, jump, estimate).unwrap_err();
        assert!(
            matches!(
                error,
                SampleLossError::Unexplained {
                    lowest: 10,
                    highest: 190,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn impossible_inputs_are_named() {
        let jump = PhaseJump {
            jump_rad: 0.0,
            tolerance_rad: -1.0,
        };
        let estimate = TimestampEstimate {
            frames: 0.0,
            uncertainty_frames: 0.0,
        };
        assert_eq!(
            lost_frames(35_000.0, 192_000, jump, estimate),
            Err(SampleLossError::Input {
                name: "tolerance_rad",
                value: -1.0,
                non_negative: true
            })
        );
        let jump = PhaseJump {
            jump_rad: 0.0,
            tolerance_rad: 0.1,
        };
        let estimate = TimestampEstimate {
            frames: 0.0,
            uncertainty_frames: 1e9,
        };
        assert!(matches!(
            lost_frames(35_000.0, 192_000, jump, estimate),
            Err(SampleLossError::TooVague { .. })
        ));
    }
}
