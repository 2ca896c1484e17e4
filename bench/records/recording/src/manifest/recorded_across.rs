//! `[plate.across]`: wavelength of the plate's mode across its width.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require_range};

/// Shortest and longest wavelength, m.
pub const WAVELENGTHS_M: [f64; 2] = [1e-4, 1.0];
/// Largest standard error of a wavelength, relative.
const MOST_RELATIVE: f64 = 0.5;

/// Amplitude across the plate: it follows cos(2πy/λ) with the distance y from the line that the finger follows.
///
/// ```
/// use recording::manifest::{RecordedAcross, WavelengthSource};
///
/// let mut across = RecordedAcross {
///     wavelength_m: 0.022,
///     standard_error_m: 3e-4,
///     source: WavelengthSource::Measured,
/// };
/// assert!(across.validate().is_ok());
/// across.standard_error_m = 0.02;
/// assert!(across.validate().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedAcross {
    /// Flexural wavelength λ at the carrier, metres.
    pub wavelength_m: f64,
    /// Standard error of λ, metres.
    pub standard_error_m: f64,
    /// Source of λ.
    pub source: WavelengthSource,
}

/// Source of a wavelength across the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WavelengthSource {
    /// Measured on this plate.
    Measured,
    /// Configured, such as from the plate's thickness.
    Configured,
}

impl RecordedAcross {
    /// Checks the range of each number.
    ///
    /// # Errors
    /// The first violated rule.
    pub fn validate(&self) -> Result<(), ManifestError> {
        let [shortest, longest] = WAVELENGTHS_M;
        let wavelength_m = self.wavelength_m;
        require_range(
            "plate.across.wavelength_m",
            wavelength_m,
            shortest..=longest,
        )?;
        require_range(
            "plate.across.standard_error_m",
            self.standard_error_m,
            0.0..=MOST_RELATIVE * wavelength_m,
        )
    }
}
