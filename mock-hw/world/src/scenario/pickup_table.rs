//! `[pickup]`: the pickup disc.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// The pickup, from plate displacement to sample value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PickupTable {
    /// Metres of plate displacement per sample value.
    pub metres_per_unit: f64,
    /// Phase by which the samples lag the displacement at the plate's resonance, rad, from a pure delay of phase_rad/ω:
    /// x̃ = metres_per_unit · sample · exp(+i·phase_rad).
    pub phase_rad: f64,
}

impl Default for PickupTable {
    fn default() -> Self {
        Self {
            metres_per_unit: 5.0e-6,
            phase_rad: 0.2,
        }
    }
}

impl PickupTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "pickup", self,
            metres_per_unit: 1e-9, 1e-3, "m";
            phase_rad: -3.15, 3.15, "rad";
        }
        Ok(())
    }
}
