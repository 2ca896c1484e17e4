//! `[reference]`: a vibrometer with its analog output on a spare input of the sound card.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::ranges::all_within;

/// Input of the sound card connected to the vibrometer's output.
pub const REFERENCE_INPUT: usize = 3;

/// The vibrometer, from the plate's middle to sample values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ReferenceTable {
    /// Quantity that the output follows.
    pub follows: Follows,
    /// Metres, or metres per second, per volt at the output.
    pub per_volt: f64,
    /// Volts at the output per sample value.
    pub volts_per_unit: f64,
    /// Delay of the output behind the plate, s.
    pub delay_s: f64,
    /// Standard deviation of the noise in one sample, V.
    pub noise_v: f64,
}

/// Quantity that a vibrometer's output follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Follows {
    /// No vibrometer; the input is quiet.
    Nothing,
    /// Displacement.
    Displacement,
    /// Velocity.
    Velocity,
}

impl Default for ReferenceTable {
    fn default() -> Self {
        Self {
            follows: Follows::Nothing,
            per_volt: 2.0e-6,
            volts_per_unit: 4.0,
            delay_s: 6.3e-6,
            noise_v: 1.0e-3,
        }
    }
}

impl ReferenceTable {
    /// Requires every number of the table to be in range, and the input to exist.
    pub(super) fn check(&self, channels: usize) -> Result<(), OutOfRange> {
        all_within! { "reference", self,
            per_volt: 1e-9, 10.0, "m or m/s";
            volts_per_unit: 1e-3, 1e3, "V";
            delay_s: 0.0, 3e-5, "s";
            noise_v: 0.0, 1.0, "V";
        }
        if self.follows == Follows::Nothing {
            return Ok(());
        }
        let min_channels = (REFERENCE_INPUT + 1) as f64;
        require_range(
            "converter.channels",
            channels as f64,
            min_channels,
            32.0,
            "",
        )
    }
}
