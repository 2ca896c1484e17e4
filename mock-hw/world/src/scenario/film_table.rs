//! `[film]`: squeeze film and asperities, without the constants of a person.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::across_table::ContactWidthTable;
use super::ranges::all_within;

/// Squeeze film and asperities (`Huloux 2021`, Eqs. 13–18): constants, unless drawn for a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FilmTable {
    /// Ambient pressure p0, Pa.
    pub ambient_pressure_pa: f64,
    /// Apparent contact area S at a normal force of 1 N, m².
    pub contact_area_m2: f64,
    /// Width of the contact across the plate; without it, the plate moves everywhere under the finger as on the mode's crest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_width: Option<ContactWidthTable>,
    /// Exponent of the normal force in the contact area; 0 for a constant area.
    pub area_force_exponent: f64,
    /// Roughness cut-off q0, rad/m (assumed: 2π over a 0.45 mm ridge).
    pub q0_rad_per_m: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Loss factor of the contact: b_c = η k_c/ω.
    pub loss_factor: f64,
    /// Time constant of levitation at a gap of 10 µm, s.
    pub lag_s: f64,
    /// Exponent of the gap in the time constant of levitation.
    pub lag_gap_exponent: f64,
    /// Sliding distance over which friction builds up, m.
    pub presliding_m: f64,
}

impl Default for FilmTable {
    fn default() -> Self {
        Self {
            ambient_pressure_pa: 101_325.0,
            contact_area_m2: 300.0e-6,
            contact_width: None,
            area_force_exponent: 0.0,
            q0_rad_per_m: 1.4e4,
            youngs_modulus_pa: 20.0e6,
            poisson_ratio: 0.5,
            loss_factor: 0.3,
            lag_s: 1.0e-3,
            lag_gap_exponent: 0.2,
            presliding_m: 0.3e-3,
        }
    }
}

impl FilmTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        if let Some(width) = &self.contact_width {
            width.check()?;
        }
        all_within! { "film", self,
            ambient_pressure_pa: 1e3, 1e6, "Pa";
            contact_area_m2: 10e-6, 1e-3, "m²";
            area_force_exponent: 0.0, 0.7, "";
            q0_rad_per_m: 1e3, 1e6, "rad/m";
            youngs_modulus_pa: 1e5, 1e9, "Pa";
            poisson_ratio: 0.0, 0.5, "";
            loss_factor: 0.0, 1.0, "";
            lag_s: 2e-4, 0.1, "s";
            lag_gap_exponent: -1.0, 1.0, "";
            presliding_m: 1e-5, 5e-3, "m";
        }
        Ok(())
    }
}
