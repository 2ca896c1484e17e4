//! State of the watch, and what may be asked of it.

use serde::Serialize;

use crate::trip::Trip;

/// State of the watch, for every screen and file.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum SafetyState {
    /// Amplifier off.
    #[default]
    Disarmed,
    /// Amplifier enabled, heartbeat running.
    Armed,
    /// Stopped and latched.
    Tripped {
        /// Why.
        trip: Trip,
    },
}

/// What the rest of the bench may ask of the watch.
#[derive(Debug, Clone, PartialEq)]
pub enum SafetyCommand {
    /// Enable the amplifier; refused while tripped.
    Arm,
    /// Disable the amplifier in an orderly way.
    Disarm,
    /// Stop at once.
    Trip(Trip),
    /// The operator has looked: back to disarmed.
    Rearm,
}
