//! `[jitter]`: spread of the true constants from seed to seed.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::ranges::all_within;

/// Spread of the true constants from seed to seed; off by default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct JitterTable {
    /// Whether the constants differ from seed to seed.
    pub enabled: bool,
    /// Half width of the range of the pickup's sensitivity, relative.
    pub pickup_sensitivity: f64,
    /// Half width of the range of the pickup's phase, rad.
    pub pickup_phase_rad: f64,
    /// Half width of the range of the plate's resonance, Hz.
    pub resonance_hz: f64,
    /// Smallest and largest quality factor of the carrier mode.
    pub quality: [f64; 2],
    /// Half width of the range of the force factor, relative.
    pub force_factor: f64,
    /// Largest skew of each channel except the first, samples; the smallest is 0.
    pub skew_samples: f64,
    /// Half width of the range of the gain of each force axis, relative.
    pub force_gain: f64,
    /// Half width of the range of the crosstalk between the force axes, as a fraction.
    pub force_crosstalk: f64,
    /// Half width of the range of each axis' reading without load, N.
    pub force_offset_n: f64,
    /// Half width of the range of each axis' steady drift, N/min.
    pub force_drift_n_per_min: f64,
    /// Largest share of the pull lost to the pulley's friction; the smallest is 0.
    pub pulley_friction: f64,
}

impl Default for JitterTable {
    fn default() -> Self {
        Self {
            enabled: false,
            pickup_sensitivity: 0.2,
            pickup_phase_rad: 0.5,
            resonance_hz: 300.0,
            quality: [150.0, 350.0],
            force_factor: 0.2,
            skew_samples: 1.0,
            force_gain: 0.2,
            force_crosstalk: 0.05,
            force_offset_n: 0.03,
            force_drift_n_per_min: 0.005,
            pulley_friction: 0.003,
        }
    }
}

impl JitterTable {
    /// Requires every number of the table to be in range; the two quality factors must ascend.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "jitter", self,
            pickup_sensitivity: 0.0, 0.9, "";
            pickup_phase_rad: 0.0, 3.15, "rad";
            resonance_hz: 0.0, 3e3, "Hz";
            force_factor: 0.0, 0.9, "";
            skew_samples: 0.0, 4.0, "samples";
            force_gain: 0.0, 0.9, "";
            force_crosstalk: 0.0, 0.3, "";
            force_offset_n: 0.0, 5.0, "N";
            force_drift_n_per_min: 0.0, 1.0, "N/min";
            pulley_friction: 0.0, 0.3, "";
        }
        let [least, most] = self.quality;
        require_range("jitter.quality", least, 10.0, most, "")?;
        require_range("jitter.quality", most, least, 1e4, "")
    }
}
