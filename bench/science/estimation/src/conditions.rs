//! Conditions shared by all instances of a recording.

use num_complex::Complex64;

use contact::AssumedConstants;
use contact::CalibrationErrors;
use contact::error::{ModelError, positive};
use contact::uncertain::Uncertain;

/// Plate's mode across its width: the amplitude follows cos(2πy/λ) with the distance y from the finger's path, on which the
/// amplitude is greatest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeAcross {
    /// Flexural wavelength λ across the plate at the carrier, m.
    pub wavelength_m: Uncertain,
}

impl ModeAcross {
    /// Returns κ = (w/λ)² of a contact of this width w, m.
    pub(super) fn width_square(&self, width_m: f64) -> f64 {
        (width_m / self.wavelength_m.value).powi(2)
    }
}

/// Width of a contact, m: the contacts of fingertips are 8 to 14 mm wide. It does not follow from S, which is the area of the
/// film's law and not that of a print: a disc of 300 mm² would be 20 mm wide.
pub(super) const CONTACT_WIDTH_M: f64 = 0.011;

/// Conditions shared by all instances of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitConditions {
    /// Assumed constants of finger and air.
    pub assumed: AssumedConstants,
    /// Carrier frequency f0, Hz.
    pub carrier_hz: f64,
    /// Z_p of the unloaded plate from the plain ratio, N·s/m, subtracted by `paper`.
    pub z_p_plain_n_s_per_m: Complex64,
    /// Z_p of the unloaded plate from the corrected ratio, N·s/m, subtracted by `dynamic`.
    pub z_p_corrected_n_s_per_m: Complex64,
    /// Errors of the calibration.
    pub calibration: CalibrationErrors,
    /// Errors assumed of constants whose errors are not known. They are in the total errors, and not in those within the published
    /// laws.
    pub assumed_errors: CalibrationErrors,
    /// Plate's mode across its width; `None` if the wavelength is not known.
    pub mode_across: Option<ModeAcross>,
}

impl FitConditions {
    #[cfg(test)]
    pub(super) fn with_plate(z_p: Complex64) -> Self {
        Self {
            assumed: AssumedConstants::default(),
            carrier_hz: 35_000.0,
            z_p_plain_n_s_per_m: z_p,
            z_p_corrected_n_s_per_m: z_p,
            calibration: CalibrationErrors::default(),
            assumed_errors: CalibrationErrors::default(),
            mode_across: None,
        }
    }

    /// Returns the errors of the calibration with the assumed ones.
    pub(super) fn total_errors(&self) -> CalibrationErrors {
        self.calibration.sum(&self.assumed_errors)
    }

    /// Returns the carrier's angular frequency ω, rad/s.
    ///
    /// # Errors
    /// If the carrier frequency is not positive.
    pub fn carrier_rad_per_s(&self) -> Result<f64, ModelError> {
        Ok(std::f64::consts::TAU * positive("carrier frequency", "Hz", self.carrier_hz)?)
    }
}
