//! `[participant.population]`: distributions from which a skin is drawn.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

/// Distributions of the skin (`Huloux 2021`, section on participants; μ0's mean and spread are assumptions).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PopulationTable {
    /// Mean and standard deviation of σ_t, m.
    pub sigma_t_m: [f64; 2],
    /// Mean and standard deviation of Re Z_t, N·s/m; never below 0.05.
    pub re_z_t_n_s_per_m: [f64; 2],
    /// Mean and standard deviation of Im Z_t, N·s/m; never below 0.5.
    pub im_z_t_n_s_per_m: [f64; 2],
    /// Mean and standard deviation of μ0; never outside 0.2 to 1.8.
    pub mu0: [f64; 2],
    /// Spearman correlation of μ0 with Im Z_t.
    pub spearman_mu0_im_z_t: f64,
}

impl Default for PopulationTable {
    fn default() -> Self {
        Self {
            sigma_t_m: [1.7e-6, 0.4e-6],
            re_z_t_n_s_per_m: [0.47, 0.28],
            im_z_t_n_s_per_m: [3.16, 0.63],
            mu0: [0.8, 0.2],
            spearman_mu0_im_z_t: -0.58,
        }
    }
}

impl PopulationTable {
    /// Requires every mean to be in range, and every standard deviation to be from 0 to its mean.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        for (key, [mean, sd], low, high, unit) in [
            (
                "participant.population.sigma_t_m",
                self.sigma_t_m,
                0.5e-6,
                4e-6,
                "m",
            ),
            (
                "participant.population.re_z_t_n_s_per_m",
                self.re_z_t_n_s_per_m,
                0.1,
                50.0,
                "N·s/m",
            ),
            (
                "participant.population.im_z_t_n_s_per_m",
                self.im_z_t_n_s_per_m,
                1.0,
                50.0,
                "N·s/m",
            ),
            ("participant.population.mu0", self.mu0, 0.3, 1.5, ""),
        ] {
            require_range(key, mean, low, high, unit)?;
            require_range(key, sd, 0.0, mean, unit)?;
        }
        require_range(
            "participant.population.spearman_mu0_im_z_t",
            self.spearman_mu0_im_z_t,
            -1.0,
            1.0,
            "",
        )
    }
}
