//! `[standard_errors]`: standard errors of the constants that convert samples to amplitudes and forces.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, within};

/// Largest allowed standard error, relative or in rad; beyond it the measurement would be meaningless.
const MOST: f64 = 0.5;

/// Standard errors of the constants, each independent of the others; one that is not stated is 0.
///
/// ```
/// use recording::manifest::StandardErrors;
///
/// let mut errors = StandardErrors { amplitude_relative: 0.005, ..Default::default() };
/// assert!(errors.validate().is_ok());
/// errors.pickup_phase_rad = -0.01;
/// assert!(errors.validate().is_err());
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StandardErrors {
    /// Of the plate's amplitude, relative: the pickup's sensitivity.
    pub amplitude_relative: f64,
    /// Of every impedance, relative: the force factor over the pickup's sensitivity.
    pub impedance_relative: f64,
    /// Of the pickup's phase against the drive, rad.
    pub pickup_phase_rad: f64,
    /// Of the normal force, relative.
    pub normal_force_relative: f64,
    /// Of the lateral force, relative.
    pub lateral_force_relative: f64,
}

impl StandardErrors {
    /// Checks the range of each standard error.
    ///
    /// # Errors
    /// The first one outside its range.
    pub fn validate(&self) -> Result<(), ManifestError> {
        for (key, value) in [
            ("amplitude_relative", self.amplitude_relative),
            ("impedance_relative", self.impedance_relative),
            ("pickup_phase_rad", self.pickup_phase_rad),
            ("normal_force_relative", self.normal_force_relative),
            ("lateral_force_relative", self.lateral_force_relative),
        ] {
            within(&format!("standard_errors.{key}"), value, 0.0..=MOST)?;
        }
        Ok(())
    }
}
