//! `[standard_errors]`: standard errors of the constants that convert samples to amplitudes and forces.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require_range};

/// Largest allowed standard error, relative, in rad or in N; beyond it the measurement would be meaningless.
const MAX_STANDARD_ERROR: f64 = 0.5;

/// Standard errors of the constants, independent of each other; 0 if not stated, of which an analysis assumes an error.
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
    /// Relative standard error of the plate's amplitude, from the pickup's sensitivity.
    pub amplitude_relative: f64,
    /// Relative standard error of every impedance, from the force factor over the pickup's sensitivity.
    pub impedance_relative: f64,
    /// Standard error of the pickup's phase relative to the drive, rad.
    pub pickup_phase_rad: f64,
    /// Relative standard error of the normal force.
    pub normal_force_relative: f64,
    /// Relative standard error of the lateral force.
    pub lateral_force_relative: f64,
    /// Standard error of the lateral force per newton of normal force: of the crosstalk between the axes. If it is 0, an
    /// analysis takes the crosstalk that the recording shows, or assumes one.
    pub lateral_per_normal: f64,
    /// Standard error of the normal force's zero, N, in addition to that with which a recording shows its zero.
    pub normal_zero_n: f64,
    /// Standard error of the lateral force's zero, N, likewise.
    pub lateral_zero_n: f64,
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
            ("lateral_per_normal", self.lateral_per_normal),
            ("normal_zero_n", self.normal_zero_n),
            ("lateral_zero_n", self.lateral_zero_n),
        ] {
            require_range(
                &format!("standard_errors.{key}"),
                value,
                0.0..=MAX_STANDARD_ERROR,
            )?;
        }
        Ok(())
    }
}
