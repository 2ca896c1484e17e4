//! `[plate.across]`: wavelength of the plate's mode across its width.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require, require_range};

/// Shortest and longest wavelength, m. The model has no contact wider than 1.5 waves, and a fingertip's contact is about 11 mm
/// wide.
pub const WAVELENGTHS_M: [f64; 2] = [8e-3, 1.0];
/// Largest standard error of a wavelength, relative.
const MOST_RELATIVE: f64 = 0.5;
/// Largest distance of a crest from the line that the finger follows, and largest standard error of it, in wavelengths: from an
/// eighth on, the amplitude rises towards one side of the finger more than it falls towards the other.
pub const FARTHEST_CREST: f64 = 0.125;

/// Amplitude across the plate: it follows cos(2π(y − y0)/λ) with the distance y from the line that the finger follows.
///
/// ```
/// use recording::manifest::{RecordedAcross, WavelengthSource};
///
/// let mut across = RecordedAcross {
///     wavelength_m: 0.022,
///     standard_error_m: 3e-4,
///     crest_m: 2e-4,
///     crest_standard_error_m: 1e-4,
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
    /// Distance y0 of the nearest crest from the line that the finger follows, metres; 0 if it was not measured.
    #[serde(default)]
    pub crest_m: f64,
    /// Standard error of y0, metres.
    #[serde(default)]
    pub crest_standard_error_m: f64,
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
        require(
            (shortest..=longest).contains(&wavelength_m),
            "plate.across.wavelength_m",
            wavelength_m,
            &format!(
                "{shortest} to {longest}: a fingertip is wider than the model's widest contact on a shorter wave"
            ),
        )?;
        require_range(
            "plate.across.standard_error_m",
            self.standard_error_m,
            0.0..=MOST_RELATIVE * wavelength_m,
        )?;
        let farthest_m = FARTHEST_CREST * wavelength_m;
        require_range(
            "plate.across.crest_m",
            self.crest_m,
            -farthest_m..=farthest_m,
        )?;
        require_range(
            "plate.across.crest_standard_error_m",
            self.crest_standard_error_m,
            0.0..=farthest_m,
        )
    }
}
