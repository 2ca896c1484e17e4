//! Quantities that a pickup may read.

use serde::{Deserialize, Serialize};

/// Quantity that a pickup may read in place of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// A velocity, which leads by a quarter of a turn.
    Velocity,
    /// An acceleration, or a displacement of the other sign.
    Acceleration,
}

impl Quantity {
    pub(crate) fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => (
                "a velocity",
                "divide metres_per_unit by 2π·carrier_hz and take π/2 from phase_rad",
            ),
            Self::Acceleration => (
                "an acceleration, or of a displacement of the other sign",
                "divide metres_per_unit by (2π·carrier_hz)² if it is one, and take π from phase_rad",
            ),
        }
    }
}
