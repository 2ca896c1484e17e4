//! `[plate.across]` and `[film.contact_width]`: the modes across the plate, and the finger's width there.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Phase from the crest at which a plate with two free edges ends, rad: half of 4.730.
const EDGE_RAD: f64 = 2.365;

/// Shape of the plate's modes across its width: a cosine, steeper in the middle of a plate with free edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct AcrossTable {
    /// Flexural wavelength λ, m.
    pub wavelength_m: f64,
    /// Position of the crest from the line that the finger follows, m.
    pub crest_m: f64,
    /// Share of the hyperbolic cosine of the same wave number, subtracted from the cosine; 0.133 for the lowest mode of a plate
    /// with two free edges.
    pub edge_share: f64,
}

impl Default for AcrossTable {
    fn default() -> Self {
        Self {
            wavelength_m: 0.022,
            crest_m: 0.0,
            edge_share: 0.0,
        }
    }
}

impl AcrossTable {
    /// Returns the amplitude at a distance from the finger's line, relative to the crest.
    pub(super) fn shape(&self, across_m: f64) -> f64 {
        let turn = std::f64::consts::TAU * (across_m - self.crest_m) / self.wavelength_m;
        // Both parts are solutions of the bending wave, d⁴u/dy⁴ = k⁴ u.
        let edge = self.edge_share * turn.abs().min(EDGE_RAD).cosh();
        (turn.cos() - edge) / (1.0 - self.edge_share)
    }

    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "plate.across", self,
            wavelength_m: 5e-3, 1.0, "m";
            crest_m: -0.02, 0.02, "m";
            edge_share: 0.0, 0.2, "";
        }
        Ok(())
    }
}

/// Contact of a finite width across the plate; the skin moves as one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ContactWidthTable {
    /// Width at a normal force of 1 N, m; it grows with the square root of the contact area.
    pub width_m: f64,
    /// Exponent n of the outline |y|ⁿ + |x|ⁿ = 1 in units of half width and half length; 2 for an ellipse.
    pub squareness: f64,
}

impl Default for ContactWidthTable {
    fn default() -> Self {
        Self {
            width_m: 0.010,
            squareness: 2.0,
        }
    }
}

impl ContactWidthTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "film.contact_width", self,
            width_m: 1e-4, 0.03, "m";
            squareness: 1.0, 20.0, "";
        }
        Ok(())
    }
}
