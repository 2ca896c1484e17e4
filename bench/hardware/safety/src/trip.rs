//! Reasons for which the watch stops the bench, and their texts.

use std::fmt;

use serde::Serialize;

use crate::dead_man::Hold;
use crate::loop_delay::DELAY_WITHIN_S;
use crate::minutes::{at_least, at_most};

/// Reason for which the bench stopped.
///
/// ```
/// use safety::Trip;
///
/// let trip = Trip::ForceLimit { normal_n: 3.5, limit_n: 3.0 };
/// assert_eq!(trip.to_string(), "normal force 3.50 N over the limit of 3.00 N");
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum Trip {
    /// The operator pressed the key, or a program requested the stop.
    Operator,
    /// The e-stop loop is open: pressed, or its wire cut.
    EmergencyStop,
    /// A GPIO line failed.
    Gpio {
        /// Error text of the backend.
        message: String,
    },
    /// Audio callbacks stopped.
    AudioSilent,
    /// The sound card was lost.
    AudioLost,
    /// The card's input buffer overran: it was read too late, and the card stopped.
    AudioOverrun,
    /// The card's output underran: it was written too late, and the card stopped.
    AudioUnderrun,
    /// The force sensor stopped sending.
    ForceSilent,
    /// The force sensor was not read for a quarter of a second.
    ForceUnread,
    /// The normal force is over its limit.
    ForceLimit {
        /// Measured, N.
        normal_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// The lateral force is over its limit, in either direction.
    LateralForceLimit {
        /// Measured, N.
        lateral_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// The force sensor's own reading is over the limit for any plausible calibration: a wrong calibration cannot hide
    /// a press.
    RawForceLimit {
        /// Axis of the sensor: `normal` or `lateral`.
        axis: &'static str,
        /// Reading of the sensor, N.
        raw_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// The normal axis is at the end of its range, so the normal force is not known.
    ForceSaturated,
    /// The read-back does not agree with the command: amplifier off, cable out, gain changed.
    Readback {
        /// Measured peak, V.
        measured_v: f64,
        /// Least and greatest command within the loop's latency, V.
        commanded_v: (f64, f64),
    },
    /// The read-back comes earlier or later than the measured delay of the loop.
    LoopDelay {
        /// Measured by `calibrate channels`, s.
        measured_s: f64,
        /// On this opening of the streams, s.
        present_s: f64,
    },
    /// The drive reads back a voltage although the amplifier is off: a welded relay, another generator.
    AliveWhileDisarmed {
        /// Measured peak, V.
        measured_v: f64,
    },
    /// The drive reads back a voltage with the amplifier on although nothing is played: another generator.
    AliveUndriven {
        /// Measured peak, V.
        measured_v: f64,
    },
    /// The force sensor's port sends bytes but no reading: wrong baud or protocol, another device.
    ForceNonsense {
        /// Number of bytes.
        bytes: u64,
    },
    /// The plate moves more than allowed.
    Amplitude {
        /// Measured by the pickup, µm.
        amplitude_um: f64,
        /// Allowed, µm.
        limit_um: f64,
    },
    /// The plate is warmer than allowed, by the estimate from its drive.
    Warm {
        /// Estimated temperature of its surface, °C.
        surface_c: f64,
        /// Allowed, °C.
        limit_c: f64,
        /// Time after which the drive may resume, s.
        wait_s: f64,
    },
    /// The plate was driven for the whole time allowed within an hour.
    Dose {
        /// Driven within the last hour, s.
        driven_s: f64,
        /// Allowed, s.
        limit_s: f64,
        /// Time after which the drive may resume, s.
        wait_s: f64,
    },
    /// The dead-man switch was released while the plate was driven.
    DeadManReleased,
    /// The drive was requested while the dead-man switch was not released and pressed.
    DeadManNotHeld {
        /// Action required first.
        hold: Hold,
    },
    /// The generator refused its own output.
    Generator,
    /// Another part of the program killed the drive, as by a panic.
    Killed,
    /// The watch did not run: the program was frozen or the computer overloaded.
    Frozen {
        /// Duration, s.
        for_s: f64,
    },
    /// The task that decides about the drive does not respond: it waits for a part that hangs.
    Unresponsive {
        /// Duration, s.
        for_s: f64,
    },
    /// The operator's keys are not read: the stop key would have no effect.
    KeysUnread {
        /// Duration, s.
        for_s: f64,
    },
    /// The read-back of the drive stopped.
    ReadbackMissing,
    /// A part of the bench failed.
    Fault {
        /// Description of the failure.
        message: String,
    },
}

impl Trip {
    /// Returns whether the reason latches even on a disarmed bench: a drive that is alive nevertheless, a failure of the
    /// program, or a lost sound card.
    pub(crate) fn latches_disarmed(&self) -> bool {
        matches!(
            self,
            Self::AliveWhileDisarmed { .. }
                | Self::Killed
                | Self::AudioLost
                | Self::AudioOverrun
                | Self::AudioUnderrun
        )
    }
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operator => f.write_str("stopped by the operator"),
            Self::EmergencyStop => f.write_str("e-stop pressed or its wire cut"),
            Self::Gpio { message } => f.write_str(message),
            Self::AudioSilent => f.write_str("audio callbacks stopped"),
            Self::AudioLost => f.write_str("the sound card is gone"),
            Self::AudioOverrun => f.write_str(
                "the card's input buffer ran over before it was read, and the card stopped: the computer was too busy",
            ),
            Self::AudioUnderrun => f.write_str(
                "the card's output ran dry before it was written, and the card stopped: the computer was too busy, or the \
                 lead is too short (nidaqmx.lead_s in bench.toml)",
            ),
            Self::ForceSilent => f.write_str("the force sensor is silent"),
            Self::ForceUnread => {
                f.write_str("the force sensor was not read for a quarter of a second")
            }
            Self::ForceLimit { normal_n, limit_n } => {
                write!(
                    f,
                    "normal force {normal_n:.2} N over the limit of {limit_n:.2} N"
                )
            }
            Self::LateralForceLimit { lateral_n, limit_n } => {
                write!(
                    f,
                    "lateral force {lateral_n:.2} N over the limit of {limit_n:.2} N either way"
                )
            }
            Self::RawForceLimit {
                axis,
                raw_n,
                limit_n,
            } => write!(
                f,
                "the force sensor itself reads {raw_n:.2} N on its {axis} axis, over the limit of {limit_n:.2} N for any calibration: calibrate it again"
            ),
            Self::ForceSaturated => {
                f.write_str("the normal force is beyond the force sensor's range")
            }
            Self::Readback {
                measured_v,
                commanded_v: (low_v, high_v),
            } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V, commanded {low_v:.1} to {high_v:.1} V"
                )
            }
            Self::LoopDelay {
                measured_s,
                present_s,
            } => write!(
                f,
                "measured loop delay {:.1} ms, this opening {:.1} ms, more than {:.0} ms off: run `friction-bench calibrate \
                 channels` again after a change of buffers or devices; if it differs from one opening to the next, link the \
                 two streams or use another device",
                1e3 * measured_s,
                1e3 * present_s,
                1e3 * DELAY_WITHIN_S
            ),
            Self::AliveWhileDisarmed { measured_v } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V although disarmed: take the finger off the plate and switch the amplifier off at the mains; its relay is welded, or another generator drives it"
                )
            }
            Self::AliveUndriven { measured_v } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V although nothing is played: take the finger off the plate and switch the amplifier off at the mains; another generator drives it"
                )
            }
            Self::ForceNonsense { bytes } => write!(
                f,
                "the force sensor has sent {bytes} bytes and no reading: compare [force] in bench.toml with the sensor (force.baud and \
                 force.protocol of a serial line), and look whether another device is in its place, or the sensor reports a failure"
            ),
            Self::Amplitude {
                amplitude_um,
                limit_um,
            } => write!(
                f,
                "the plate moves by {amplitude_um:.2} µm, over the limit of {limit_um:.2} µm (limits.amplitude_um): lower the drive, or calibrate the pickup"
            ),
            Self::Warm {
                surface_c,
                limit_c,
                wait_s,
            } => write!(
                f,
                "the plate is estimated at {surface_c:.1} °C, at its limit of {limit_c:.1} °C (limits.surface_c): go on in {:.0} s",
                wait_s.ceil()
            ),
            Self::Dose {
                driven_s,
                limit_s,
                wait_s,
            } => write!(
                f,
                "the plate was driven for {} within an hour, of at most {limit_s:.0} s (limits.driving_s_per_hour): go on in {}",
                at_most(*driven_s),
                at_least(*wait_s)
            ),
            Self::DeadManReleased => {
                f.write_str("the dead-man switch was released: press it again, and re-arm")
            }
            Self::DeadManNotHeld { hold: Hold::Release } => f.write_str(
                "the dead-man switch has not been released since the last drive, or does not open: release it, then hold it",
            ),
            Self::DeadManNotHeld { .. } => {
                f.write_str("the dead-man switch is not held: press and hold it")
            }
            Self::Generator => f.write_str("the generator refused an impossible output"),
            Self::Killed => f.write_str("a part of the program failed and stopped the drive"),
            Self::Frozen { for_s } => {
                write!(f, "the safety watch itself did not run for {for_s:.2} s")
            }
            Self::Unresponsive { for_s } => write!(
                f,
                "the part of the program that decides about the drive has not responded for {for_s:.1} s: look whether a disk, a \
                 network share or a device hangs, then re-arm"
            ),
            Self::KeysUnread { for_s } => write!(
                f,
                "the operator's keys have not been read for {for_s:.1} s, the stop key included: look whether the terminal or its \
                 connection hangs, then re-arm"
            ),
            Self::ReadbackMissing => f.write_str("the drive is no longer read back"),
            Self::Fault { message } => f.write_str(message),
        }
    }
}
