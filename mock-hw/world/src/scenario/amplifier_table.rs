//! `[amplifier]`: the amplifier between generator and actuators.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// The amplifier, from generator output to actuator voltage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct AmplifierTable {
    /// Actuator volts per full-scale unit of generator output, at frequencies far below the roll-off.
    pub volts_per_unit: f64,
    /// Corner frequency of the first-order roll-off, Hz.
    pub bandwidth_hz: f64,
    /// Time for which the amplifier stays enabled after a heartbeat edge, s.
    pub one_shot_s: f64,
    /// Whether the relay is welded, so that it never opens, regardless of enable, heartbeat and e-stop.
    pub relay_welded: bool,
}

impl Default for AmplifierTable {
    fn default() -> Self {
        Self {
            volts_per_unit: 60.0,
            bandwidth_hz: 200_000.0,
            one_shot_s: 0.1,
            relay_welded: false,
        }
    }
}

impl AmplifierTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "amplifier", self,
            volts_per_unit: 0.1, 1e3, "V";
            bandwidth_hz: 40e3, 10e6, "Hz";
            one_shot_s: 1e-3, 10.0, "s";
        }
        Ok(())
    }
}
