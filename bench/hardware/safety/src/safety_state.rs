//! State of the watch, and the commands that it takes.

use serde::Serialize;

use crate::dose::Allowance;
use crate::trip::Trip;

/// State of the watch, for every screen and file.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum SafetyState {
    /// The amplifier is off.
    #[default]
    Disarmed,
    /// The amplifier is enabled and the heartbeat runs.
    Armed,
    /// The drive was stopped; latched until the operator re-arms.
    Tripped {
        /// Reason of the stop.
        trip: Trip,
    },
}

/// Command to the watch from the rest of the bench.
#[derive(Debug, Clone)]
pub enum SafetyCommand {
    /// Enable the amplifier; ignored while tripped.
    Arm,
    /// Disable the amplifier in an orderly way.
    Disarm,
    /// Stop at once.
    Trip(Trip),
    /// Count the driving time under this allowance, starting with the earlier driving.
    Allow(Allowance),
    /// Begin the estimate of the plate's temperature at least this much above the room.
    Warm {
        /// Temperature above the room, K.
        rise_k: f64,
    },
    /// Exercise the hardware stops that are wired, during the steady tone; ignored unless armed.
    Exercise,
    /// Release a trip after the operator has confirmed: back to disarmed, unless the e-stop is pressed or a device is lost.
    Rearm,
}
