//! `[force_sensor.gauges]`: the amplifier between a sensor's gauges and the sound card.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

/// Number of gauges of a sensor.
pub const GAUGES: usize = 6;
/// First input that reads a gauge; the others follow.
pub const FIRST_GAUGE: usize = 3;

/// The amplifier between a sensor's gauges and the sound card's inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GaugesTable {
    /// Delay of the amplifier's filter, s.
    pub delay_s: f64,
    /// White noise of each gauge per frame, V RMS.
    pub noise_v: f64,
    /// Offset of each gauge without load, V.
    pub offset_v: f64,
    /// Corner frequency of a series capacitor, Hz; no capacitor if absent.
    pub ac_hz: Option<f64>,
}

impl Default for GaugesTable {
    fn default() -> Self {
        Self {
            delay_s: 2e-4,
            noise_v: 2e-4,
            offset_v: 0.0,
            ac_hz: None,
        }
    }
}

impl GaugesTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        // Forces are computed 0.1 ms ahead of the frames that show them.
        require_range(
            "force_sensor.gauges.delay_s",
            self.delay_s,
            1.5e-4,
            0.05,
            "s",
        )?;
        require_range("force_sensor.gauges.noise_v", self.noise_v, 0.0, 1.0, "V")?;
        require_range(
            "force_sensor.gauges.offset_v",
            self.offset_v,
            -1.0,
            1.0,
            "V",
        )?;
        match self.ac_hz {
            Some(hz) => require_range("force_sensor.gauges.ac_hz", hz, 1e-3, 100.0, "Hz"),
            None => Ok(()),
        }
    }
}
