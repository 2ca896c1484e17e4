//! `[participant.moisture]`: slow change of the skin.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Moisture of the skin: a slow random walk about its mean, common to σ_t, Z_t and μ0, and a growth under the finger.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MoistureTable {
    /// Standard deviation of the relative change of μ0; Z_t changes by −0.7 times, and σ_t by −0.3 times, this change.
    pub relative_sd: f64,
    /// Correlation time of the walk, s.
    pub time_s: f64,
    /// Relative growth of σ_t and Im Z_t after a long touch (assumed: sweat trapped by the glass); drawn for a person if
    /// `spread` gives a range.
    pub growth: f64,
    /// Time constant of the growth during touch, and of its loss after lift-off, s.
    pub growth_time_s: f64,
}

impl Default for MoistureTable {
    fn default() -> Self {
        Self {
            relative_sd: 0.03,
            time_s: 20.0,
            growth: 0.0,
            growth_time_s: 3.0,
        }
    }
}

impl MoistureTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "participant.moisture", self,
            relative_sd: 0.0, 0.2, "";
            time_s: 0.1, 1e4, "s";
            growth: -0.5, 1.0, "";
            growth_time_s: 0.1, 1e4, "s";
        }
        Ok(())
    }
}
