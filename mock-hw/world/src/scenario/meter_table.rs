//! `[meter]`: an independent voltmeter across the actuators.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// The voltmeter: true RMS of the actuators' voltage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MeterTable {
    /// Standard deviation of the gain between meters, relative.
    pub error: f64,
    /// Standard deviation of the noise of one reading, V.
    pub noise_v: f64,
}

impl Default for MeterTable {
    fn default() -> Self {
        Self {
            error: 3.0e-3,
            noise_v: 2.0e-3,
        }
    }
}

impl MeterTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "meter", self,
            error: 0.0, 0.1, "";
            noise_v: 0.0, 1.0, "V";
        }
        Ok(())
    }
}
