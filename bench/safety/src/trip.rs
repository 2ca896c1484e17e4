//! Why a bench stops, in words.

use std::fmt;

use serde::Serialize;

/// Why the bench stopped.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum Trip {
    /// The operator's key, or a program that asked for it.
    Operator,
    /// The e-stop loop is open: pressed, or its wire cut.
    EmergencyStop,
    /// A GPIO line failed.
    Gpio {
        /// What the backend said.
        message: String,
    },
    /// The sound card stopped calling.
    AudioSilent,
    /// The sound card is gone.
    AudioLost,
    /// The force sensor stopped sending.
    ForceSilent,
    /// Too much normal force.
    ForceLimit {
        /// Measured, N.
        normal_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// Too much lateral force, either way.
    LateralForceLimit {
        /// Measured, N.
        lateral_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// Too much on the force sensor itself, whatever its calibration makes of it: a wrong calibration hides no press.
    RawForceLimit {
        /// Which of its axes.
        axis: &'static str,
        /// What the sensor says, N.
        raw_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// The normal axis is at the end of its range: how hard the finger presses is not known.
    ForceSaturated,
    /// The read-back is not what was commanded: amplifier off, cable out, gain changed.
    Readback {
        /// Measured peak, V.
        measured_v: f64,
        /// Least and greatest command within the loop's latency, V.
        commanded_v: (f64, f64),
    },
    /// The drive is alive although the bench is disarmed: a welded relay, another generator.
    AliveWhileDisarmed {
        /// Measured peak, V.
        measured_v: f64,
    },
    /// The generator refused its own output.
    Generator,
    /// The kill switch was thrown by another than the watch: a part of the program panicked.
    Killed,
    /// The watch itself did not run: the program was frozen, or the computer too busy to be trusted.
    Frozen {
        /// For so long, s.
        for_s: f64,
    },
    /// Nothing is read back of the drive.
    ReadbackMissing,
    /// A part of the bench failed.
    Fault {
        /// What it said.
        message: String,
    },
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operator => f.write_str("stopped by the operator"),
            Self::EmergencyStop => f.write_str("e-stop pressed or its wire cut"),
            Self::Gpio { message } => f.write_str(message),
            Self::AudioSilent => f.write_str("audio callbacks stopped"),
            Self::AudioLost => f.write_str("the sound card is gone"),
            Self::ForceSilent => f.write_str("the force sensor is silent"),
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
            Self::AliveWhileDisarmed { measured_v } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V although disarmed: switch the amplifier off at the mains"
                )
            }
            Self::Generator => f.write_str("the generator refused an impossible output"),
            Self::Killed => f.write_str("a part of the program failed and stopped the drive"),
            Self::Frozen { for_s } => {
                write!(f, "the safety watch itself did not run for {for_s:.2} s")
            }
            Self::ReadbackMissing => f.write_str("the drive is not read back any more"),
            Self::Fault { message } => f.write_str(message),
        }
    }
}
