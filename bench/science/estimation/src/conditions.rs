//! Conditions shared by all instances of a recording.

use num_complex::Complex64;

use contact::AssumedConstants;
use contact::CalibrationErrors;
use contact::error::{ModelError, positive};
use contact::uncertain::Uncertain;

/// Plate's mode across its width: the amplitude follows cos(2π(y − y0)/λ) with the distance y from the finger's path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeAcross {
    /// Flexural wavelength λ across the plate at the carrier, m.
    pub wavelength_m: Uncertain,
    /// Distance y0 of the crest from the finger's path, m.
    pub crest_m: Uncertain,
}

/// Shortest wavelength of a [`ModeAcross`], m. A fingertip's contact is 1.4 wavelengths wide there, and the model has none
/// wider than 1.5 (`contact::mode_moments`).
pub const SHORTEST_WAVELENGTH_M: f64 = 8e-3;

impl ModeAcross {
    /// Checks that a fingertip's contact is not wider than the model's widest.
    pub(super) fn validate(&self) -> Result<(), ModelError> {
        let value = self.wavelength_m.value;
        if value >= SHORTEST_WAVELENGTH_M {
            return Ok(());
        }
        Err(ModelError::OutOfRange {
            name: "wavelength across the plate",
            value,
            unit: "m",
            limit: "at least 0.008, as a fingertip is wider than the model's widest contact on a shorter wave",
        })
    }

    /// Returns κ of a contact of width w, m: (w/λ)² if its middle is on the crest, and less away from it.
    ///
    /// Relative to the finger's path the mode is m(y) = cos(2π(y − y0)/λ)/cos t, t = 2πy0/λ. Over a contact that is symmetric about
    /// y = 0, with c_2 = ⟨cos(4πy/λ)⟩ of `contact::mode_moments`,
    ///
    /// ```text
    /// ⟨m²⟩ = (1 + c_2 cos 2t)/(2 cos² t) = 1 − (1 − tan² t)(1 − c_2)/2
    /// ```
    ///
    /// and 1 − c_2 goes as (w/λ)² to first order. So the film's mean pressure is that of a contact on the crest with
    /// κ = (1 − tan² t)(w/λ)².
    pub(super) fn width_square(&self, width_m: Uncertain) -> Uncertain {
        let (wavelength, crest) = (self.wavelength_m, self.crest_m);
        let square = (width_m.value / wavelength.value).powi(2);
        let turn = std::f64::consts::TAU * crest.value / wavelength.value;
        let share = 1.0 - turn.tan().powi(2);
        // d(1 − tan² t)/dt = −2 tan t/cos² t; ∂t/∂y0 = 2π/λ, ∂t/∂λ = −t/λ.
        let by_turn = -2.0 * square * turn.tan() / turn.cos().powi(2);
        let by_width = 2.0 * square * share / width_m.value;
        let by_wavelength = (-2.0 * square * share - by_turn * turn) / wavelength.value;
        let by_crest = by_turn * std::f64::consts::TAU / wavelength.value;
        let errors = [
            by_width * width_m.std,
            by_wavelength * wavelength.std,
            by_crest * crest.std,
        ];
        Uncertain {
            value: square * share,
            std: errors.into_iter().fold(0.0, f64::hypot),
        }
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

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use contact::mode_moments::ModeMoments;

    use super::*;

    fn exactly(value: f64) -> Uncertain {
        Uncertain { value, std: 0.0 }
    }

    /// Compares ⟨m²⟩ of the contact's κ with a sum over the strips of an ellipse away from the crest.
    #[test]
    fn a_contact_away_from_the_crest_has_the_pressure_of_a_narrower_one() {
        let (width_m, wavelength_m) = (4e-3, 0.022);
        for crest_m in [0.0, 0.4e-3, -1.1e-3, 2.5e-3] {
            let mode = ModeAcross {
                wavelength_m: exactly(wavelength_m),
                crest_m: exactly(crest_m),
            };
            let square = mode.width_square(exactly(width_m)).value;
            let [_, mean_square, ..] = ModeMoments::new(square).unwrap().means;
            let (mut sum, mut weights) = (0.0, 0.0);
            for strip in 0..2000 {
                let angle = std::f64::consts::PI * ((f64::from(strip) + 0.5) / 2000.0 - 0.5);
                let turn = |across_m: f64| {
                    (std::f64::consts::TAU * (across_m - crest_m) / wavelength_m).cos()
                };
                let weight = angle.cos().powi(2);
                weights += weight;
                sum += weight * (turn(0.5 * width_m * angle.sin()) / turn(0.0)).powi(2);
            }
            assert_relative_eq!(mean_square, sum / weights, max_relative = 1e-3);
        }
    }

    #[test]
    fn the_error_of_a_width_is_its_derivatives_times_the_errors() {
        let mode = |wavelength_m: f64, crest_m: f64| ModeAcross {
            wavelength_m: Uncertain {
                value: wavelength_m,
                std: 3e-4,
            },
            crest_m: Uncertain {
                value: crest_m,
                std: 2e-4,
            },
        };
        let width_m = Uncertain {
            value: 0.011,
            std: 3e-3,
        };
        let square = |step: [f64; 3]| {
            let width_m = exactly(width_m.value + step[0]);
            mode(0.022 + step[1], 9e-4 + step[2])
                .width_square(width_m)
                .value
        };
        let errors = [3e-3, 3e-4, 2e-4];
        let parts = [0, 1, 2].map(|i| {
            let mut step = [0.0; 3];
            step[i] = 1e-6;
            let above = square(step);
            step[i] = -1e-6;
            (above - square(step)) / 2e-6 * errors[i]
        });
        let std = mode(0.022, 9e-4).width_square(width_m).std;
        let expected = parts.into_iter().fold(0.0, f64::hypot);
        assert_relative_eq!(std, expected, max_relative = 1e-6);
    }

    #[test]
    fn a_wave_shorter_than_a_finger_is_refused_with_the_reason() {
        let mode = |wavelength_m: f64| ModeAcross {
            wavelength_m: exactly(wavelength_m),
            crest_m: exactly(0.0),
        };
        assert_eq!(mode(SHORTEST_WAVELENGTH_M).validate(), Ok(()));
        // The contact of a fingertip is within the model there.
        let widest = mode(SHORTEST_WAVELENGTH_M).width_square(exactly(CONTACT_WIDTH_M));
        assert!(ModeMoments::new(widest.value).is_some());
        for wavelength_m in [7.9e-3, f64::NAN] {
            let error = mode(wavelength_m).validate().unwrap_err().to_string();
            assert!(error.contains("a fingertip is wider"), "{error}");
        }
    }
}
