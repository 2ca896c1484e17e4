//! `[[clocks]]`: drift and state of the clocks that give the times of readings.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require_finite, require_not_negative};

/// Clock of a device during a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedClock {
    /// Device of the clock.
    pub of: ClockDevice,
    /// Excess of the clock's rate over the sound card's, or of the sound card's over the computer's, parts per million.
    pub drift_ppm: f64,
    /// Largest difference between the arrival of readings and the times given by the clock, s, each a median over 5 s; absent
    /// if not yet known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_s: Option<f64>,
}

/// Device with a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ClockDevice {
    /// The sound card; its clock is the time base of the recording.
    SoundCard,
    /// The force sensor.
    ForceSensor,
    /// The counter of the encoder.
    Encoder,
}

impl RecordedClock {
    /// Checks the rules of entry number `index`.
    pub(super) fn validate(&self, index: usize) -> Result<(), ManifestError> {
        require_finite(&format!("clocks.{index}.drift_ppm"), self.drift_ppm)?;
        let residual_s = self.residual_s.unwrap_or(0.0);
        require_not_negative(&format!("clocks.{index}.residual_s"), residual_s)
    }
}
