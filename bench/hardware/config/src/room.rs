//! State of the room.

use serde::{Deserialize, Serialize};

use super::refusal::Refused;

/// `[room]`: state of the room, as read from its instruments.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Ambient pressure at the bench, read from a barometer and not reduced to sea level, hPa; recorded, and used as p0 of the
    /// squeeze film. The standard atmosphere is assumed if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_hpa: Option<f64>,
}

impl Room {
    /// Lowest and highest ambient pressure, hPa: about 5.5 km above and 700 m below sea level.
    pub const PRESSURE_HPA: [f64; 2] = [500.0, 1100.0];

    pub(super) fn check(self) -> Result<(), Refused> {
        match self.pressure_hpa {
            Some(pressure_hpa) => Ok(require_pressure("room.pressure_hpa", pressure_hpa)?),
            None => Ok(()),
        }
    }

    /// Returns whether nothing is stated.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Requires an ambient pressure in the allowed range; `key` names it in the error.
pub(super) fn require_pressure(
    key: &str,
    pressure_hpa: f64,
) -> Result<(), strict_toml::OutOfRange> {
    let [lowest, highest] = Room::PRESSURE_HPA;
    strict_toml::require_range(key, pressure_hpa, lowest, highest, "hPa")
}
