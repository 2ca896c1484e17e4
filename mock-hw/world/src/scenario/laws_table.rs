//! `[laws]`: deviations from the published laws, on which `Huloux 2021` and every estimator built on it rely.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::ranges::all_within;

/// Departures from the published laws of the contact; inactive by default. All sizes are assumptions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LawsTable {
    /// Height at which the asperities end, in units of the standard deviation, 3 σ_t, of their normally distributed heights;
    /// their force then follows Greenwood and Williamson (1966). If absent, their force is exponential.
    pub asperity_cutoff: Option<f64>,
    /// Attraction between skin and plate at zero gap, N.
    pub adhesion_n: f64,
    /// Distance over which the attraction falls to 1/e, m.
    pub adhesion_range_m: f64,
    /// Gap at which half of the film's pressure has leaked from under the ridges; the leak grows with the gap's fourth power,
    /// as the inverse square of the squeeze number does. No leak if absent.
    pub leak_gap_m: Option<f64>,
    /// Exponent of the normal force, relative to 1 N, in Z_t of a touching finger; Z_t changes at most fivefold.
    pub tissue_force_exponent: f64,
    /// Exponent of the contact stiffness, relative to 0.1 N/µm, in the loss factor, which grows at most threefold for a stiffer
    /// contact; −1 makes the damping constant.
    pub loss_exponent: f64,
}

impl Default for LawsTable {
    fn default() -> Self {
        Self {
            asperity_cutoff: None,
            adhesion_n: 0.0,
            adhesion_range_m: 3e-6,
            leak_gap_m: None,
            tissue_force_exponent: 0.0,
            loss_exponent: 0.0,
        }
    }
}

impl LawsTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        if let Some(cutoff) = self.asperity_cutoff {
            require_range("laws.asperity_cutoff", cutoff, 2.5, 6.0, "")?;
        }
        if let Some(gap_m) = self.leak_gap_m {
            require_range("laws.leak_gap_m", gap_m, 2e-6, 1e-3, "m")?;
        }
        all_within! { "laws", self,
            adhesion_n: 0.0, 1.0, "N";
            adhesion_range_m: 0.5e-6, 20e-6, "m";
            tissue_force_exponent: -1.0, 1.0, "";
            loss_exponent: -1.0, 1.0, "";
        }
        Ok(())
    }
}
