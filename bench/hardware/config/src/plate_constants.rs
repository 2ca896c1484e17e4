//! Constants of the plate.

use serde::{Deserialize, Serialize};

use super::refusal::{Refused, require_range};

/// `[plate]`: constants of the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Name that distinguishes this plate from others of its kind.
    pub id: String,
    /// Resonance of the driven mode, Hz; the carrier of protocols that request the plate's resonance.
    pub resonance_hz: f64,
    /// Modal mass, kg.
    pub modal_mass_kg: f64,
    /// Relative standard error of the modal mass; 0 by default, as for an exact value.
    #[serde(default)]
    pub modal_mass_relative_error: f64,
    /// Force factor γ: f_a = γ U_a, N/V.
    pub force_factor_n_per_v: f64,
    /// Length along which the finger slides, m.
    pub length_m: f64,
    /// Position of the plate's centre, m.
    pub centre_m: f64,
    /// Width across which `calibrate plate --across` measures, m; the line that the finger follows is in its middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// Thickness, m, from which `check` estimates the wavelength across a plate of glass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_m: Option<f64>,
    /// Flexural wavelength across the plate's width at the carrier, m, used where `calibrate plate --across` has measured none; at
    /// least 8 mm, as a fingertip is wider than the model's widest contact on a shorter wave.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelength_across_m: Option<f64>,
    /// Relative standard error of that wavelength; 0.1 by default (an assumption).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelength_across_relative_error: Option<f64>,
    /// Heat capacity, J/K; 14 J/K by default, an assumption: 17 g of glass.
    #[serde(default = "Plate::default_heat_capacity")]
    pub heat_capacity_j_per_k: f64,
    /// Heat loss of the plate to the room, W/K; 0.1 W/K by default (an assumption).
    #[serde(default = "Plate::default_heat_loss")]
    pub heat_loss_w_per_k: f64,
    /// Temperature of the room, °C.
    #[serde(default = "Plate::default_room")]
    pub room_c: f64,
}

impl Plate {
    pub(super) fn check(&self) -> Result<(), Refused> {
        require_range("plate.resonance_hz", self.resonance_hz, 1e3, 2e5, "Hz")?;
        require_range("plate.modal_mass_kg", self.modal_mass_kg, 1e-5, 1.0, "kg")?;
        let mass_error = self.modal_mass_relative_error;
        require_range("plate.modal_mass_relative_error", mass_error, 0.0, 0.3, "")?;
        let force_factor = self.force_factor_n_per_v;
        require_range("plate.force_factor_n_per_v", force_factor, 1e-4, 1e2, "N/V")?;
        require_range("plate.length_m", self.length_m, 0.01, 1.0, "m")?;
        require_range("plate.centre_m", self.centre_m, 0.0, self.length_m, "m")?;
        self.check_across()?;
        let capacity = self.heat_capacity_j_per_k;
        require_range("plate.heat_capacity_j_per_k", capacity, 0.1, 1e4, "J/K")?;
        let loss = self.heat_loss_w_per_k;
        require_range("plate.heat_loss_w_per_k", loss, 1e-3, 10.0, "W/K")?;
        require_range("plate.room_c", self.room_c, 5.0, 27.0, "°C")
    }

    /// Shortest and longest wavelength across the plate, m. The model has no contact wider than 1.5 waves, and a fingertip's contact
    /// is about 11 mm wide.
    pub const WAVELENGTHS_ACROSS_M: [f64; 2] = [8e-3, 0.5];

    fn check_across(&self) -> Result<(), Refused> {
        let require = |key, value: Option<f64>, low, high| {
            value.map_or(Ok(()), |m| require_range(key, m, low, high, "m"))
        };
        require("plate.width_m", self.width_m, 4e-3, 0.5)?;
        require("plate.thickness_m", self.thickness_m, 1e-4, 0.02)?;
        let [shortest, longest] = Self::WAVELENGTHS_ACROSS_M;
        let wavelength_m = self.wavelength_across_m;
        require("plate.wavelength_across_m", wavelength_m, shortest, longest).map_err(
            |refused| Refused {
                why: format!(
                    "{}; a fingertip is wider than the model's widest contact on a shorter wave",
                    refused.why
                ),
                ..refused
            },
        )?;
        let error = self.wavelength_across_relative_error;
        error.map_or(Ok(()), |error| {
            require_range(
                "plate.wavelength_across_relative_error",
                error,
                1e-3,
                0.5,
                "",
            )
        })
    }

    pub(crate) fn default_heat_capacity() -> f64 {
        14.0
    }

    pub(crate) fn default_heat_loss() -> f64 {
        0.1
    }

    pub(crate) fn default_room() -> f64 {
        25.0
    }
}
