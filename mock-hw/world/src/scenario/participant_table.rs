//! `[participant]`: the person.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::behaviour_table::BehaviourTable;
use super::moisture_table::MoistureTable;
use super::population_table::PopulationTable;
use super::spread_table::SpreadTable;

/// The person: fixed values, or values drawn by seed from the population.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ParticipantTable {
    /// Asperity scale σ_t, m; drawn when absent.
    pub sigma_t_m: Option<f64>,
    /// Tissue impedance Z_t at the plate's resonance, real and imaginary part, N·s/m; drawn when absent.
    pub z_t_n_s_per_m: Option<[f64; 2]>,
    /// Friction coefficient without vibration; drawn when absent.
    pub mu0: Option<f64>,
    /// Distributions from which absent values are drawn.
    pub population: PopulationTable,
    /// Ranges from which the contact with the plate is drawn.
    pub spread: SpreadTable,
    /// Slow change of the skin within a session.
    pub moisture: MoistureTable,
    /// Movement and force of the person.
    pub behaviour: BehaviourTable,
}

impl ParticipantTable {
    /// Requires every number of the table and of its tables to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        if let Some(sigma_t_m) = self.sigma_t_m {
            require_range("participant.sigma_t_m", sigma_t_m, 0.3e-6, 6e-6, "m")?;
        }
        if let Some([re, im]) = self.z_t_n_s_per_m {
            require_range("participant.z_t_n_s_per_m (real)", re, 0.05, 100.0, "N·s/m")?;
            require_range(
                "participant.z_t_n_s_per_m (imaginary)",
                im,
                0.5,
                100.0,
                "N·s/m",
            )?;
        }
        if let Some(mu0) = self.mu0 {
            require_range("participant.mu0", mu0, 0.05, 3.0, "")?;
        }
        self.population.check()?;
        self.spread.check()?;
        self.moisture.check()?;
        self.behaviour.check()
    }
}
