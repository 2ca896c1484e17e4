//! Channels of the impedance.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Channel of the impedance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// Actuator voltage.
    Drive,
    /// Plate displacement.
    Pickup,
}

impl Channel {
    /// Returns the other channel.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Drive => Self::Pickup,
            Self::Pickup => Self::Drive,
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Drive => "drive",
            Self::Pickup => "pickup",
        })
    }
}
