//! `[jitter]`: how far the true constants differ from seed to seed.

use serde::{Deserialize, Serialize};
use strict::{OutOfRange, within};

/// Spread of the true constants from seed to seed. Off by default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JitterTable {
    /// Whether [`Scenario::realised`] changes anything.
    pub enabled: bool,
    /// Pickup sensitivity, ± relative.
    pub pickup_sensitivity: f64,
    /// Pickup phase, ± rad.
    pub pickup_phase_rad: f64,
    /// Plate resonance, ± Hz.
    pub resonance_hz: f64,
    /// Quality factor of the carrier mode, from and to.
    pub quality: [f64; 2],
    /// Force factor, ± relative.
    pub force_factor: f64,
    /// Skew of each channel but the first, 0 to this many samples.
    pub skew_samples: f64,
    /// Gain of each axis of the force sensor, ± relative.
    pub force_gain: f64,
    /// Crosstalk between its axes, ± fraction.
    pub force_crosstalk: f64,
    /// Readings without load, ± N.
    pub force_offset_n: f64,
    /// Steady drift of each axis, ± N/min.
    pub force_drift_n_per_min: f64,
    /// Share that the pulley keeps, 0 to this.
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
    /// Requires every number of the table to lie in its range; the two quality factors must ascend.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        within(
            "jitter.pickup_sensitivity",
            self.pickup_sensitivity,
            0.0,
            0.9,
            "",
        )?;
        within(
            "jitter.pickup_phase_rad",
            self.pickup_phase_rad,
            0.0,
            3.15,
            "rad",
        )?;
        within("jitter.resonance_hz", self.resonance_hz, 0.0, 3e3, "Hz")?;
        within("jitter.force_factor", self.force_factor, 0.0, 0.9, "")?;
        within(
            "jitter.skew_samples",
            self.skew_samples,
            0.0,
            4.0,
            "samples",
        )?;
        within("jitter.force_gain", self.force_gain, 0.0, 0.9, "")?;
        within("jitter.force_crosstalk", self.force_crosstalk, 0.0, 0.3, "")?;
        within("jitter.force_offset_n", self.force_offset_n, 0.0, 5.0, "N")?;
        within(
            "jitter.force_drift_n_per_min",
            self.force_drift_n_per_min,
            0.0,
            1.0,
            "N/min",
        )?;
        within("jitter.pulley_friction", self.pulley_friction, 0.0, 0.3, "")?;
        let [least, most] = self.quality;
        within("jitter.quality", least, 10.0, most, "")?;
        within("jitter.quality", most, least, 1e4, "")
    }
}
