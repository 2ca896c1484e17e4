//! `[room]`: state of the room during a recording.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require_range};

/// Lowest and highest ambient pressure, hPa: about 5.5 km above and 700 m below sea level.
pub const PRESSURE_HPA: [f64; 2] = [500.0, 1100.0];

/// Room of a recording.
///
/// ```
/// use recording::manifest::RecordedRoom;
///
/// let room = RecordedRoom { pressure_hpa: 850.0 };
/// assert_eq!(room.ambient_pressure_pa(), 85_000.0);
/// assert!(RecordedRoom { pressure_hpa: 85_000.0 }.validate().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedRoom {
    /// Ambient pressure at the bench, read from a barometer and not reduced to sea level, hPa.
    pub pressure_hpa: f64,
}

impl RecordedRoom {
    /// Returns the ambient pressure p0, Pa.
    #[must_use]
    pub fn ambient_pressure_pa(self) -> f64 {
        100.0 * self.pressure_hpa
    }

    /// Checks the range of the pressure.
    ///
    /// # Errors
    /// The pressure is outside its range.
    pub fn validate(self) -> Result<(), ManifestError> {
        let [lowest, highest] = PRESSURE_HPA;
        require_range("room.pressure_hpa", self.pressure_hpa, lowest..=highest)
    }
}
