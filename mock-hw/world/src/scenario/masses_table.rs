//! `[masses]`: known masses on the plate or over a pulley.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Known masses, which press on the plate or pull over the pulley towards increasing position.
///
/// The masses load the sensor but do not change the plate's vibration: they are for a plate at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MassesTable {
    /// Acceleration of gravity at the bench, m/s².
    pub gravity_m_per_s2: f64,
    /// Standard deviation of a mass from its nominal value, relative.
    pub error: f64,
    /// Tilt of the plate, rad, positive where it slopes down towards increasing position; the string stays level.
    pub tilt_rad: f64,
    /// Share of the pull lost to the pulley's friction.
    pub pulley_friction: f64,
    /// Frequency at which a mass placed on the plate bounces, Hz.
    pub bounce_hz: f64,
    /// Time constant of the decay of the bouncing, s.
    pub bounce_time_s: f64,
    /// Frequency at which a mass hung over the pulley swings, Hz.
    pub swing_hz: f64,
    /// Time constant of the decay of the swinging, s.
    pub swing_time_s: f64,
}

impl Default for MassesTable {
    fn default() -> Self {
        Self {
            gravity_m_per_s2: 9.806_65,
            error: 5.0e-5,
            tilt_rad: 0.0,
            pulley_friction: 0.0,
            bounce_hz: 12.0,
            bounce_time_s: 0.08,
            swing_hz: 2.5,
            swing_time_s: 0.2,
        }
    }
}

impl MassesTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "masses", self,
            gravity_m_per_s2: 9.76, 9.84, "m/s²";
            error: 0.0, 0.1, "";
            tilt_rad: -0.2, 0.2, "rad";
            pulley_friction: 0.0, 0.5, "";
            bounce_hz: 0.5, 100.0, "Hz";
            bounce_time_s: 0.01, 100.0, "s";
            swing_hz: 0.5, 100.0, "Hz";
            swing_time_s: 0.01, 100.0, "s";
        }
        Ok(())
    }
}
