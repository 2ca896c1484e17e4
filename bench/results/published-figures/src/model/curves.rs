//! Curves of all figures, and their tables.

use std::path::{Path, PathBuf};

use anyhow::Context;
use contact::ModelError;
use serde::Serialize;

use super::parameters::ModelParameters;
use super::rows::{
    self, Balance, ContactMotion, Friction, Gap, Impedance, ImpedanceByStiffness, Squeeze,
    Stiffness,
};

/// Curves of all figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Fig. 3: Z_m and |ṽ_t/ṽ_p| against k_c.
    pub impedance_by_stiffness: Vec<ImpedanceByStiffness>,
    /// Fig. 5a: force that the asperities leave to the film.
    pub balance: Vec<Balance>,
    /// Fig. 5a: force of the film.
    pub squeeze: Vec<Squeeze>,
    /// Fig. 5b: gap against amplitude and force.
    pub gap: Vec<Gap>,
    /// Fig. 6: k_c against amplitude and force.
    pub stiffness: Vec<Stiffness>,
    /// Fig. 7b: Z_m against amplitude and force.
    pub impedance: Vec<Impedance>,
    /// Fig. 8: plate and skin in time.
    pub motion: Vec<ContactMotion>,
    /// Fig. 9: μ against amplitude and force.
    pub friction: Vec<Friction>,
}

impl Curves {
    /// Computes all curves.
    ///
    /// # Errors
    /// A parameter has no physical meaning.
    pub fn compute(parameters: &ModelParameters) -> Result<Self, ModelError> {
        Ok(Self {
            impedance_by_stiffness: rows::impedance_by_stiffness(parameters),
            balance: rows::balance(parameters)?,
            squeeze: rows::squeeze(parameters)?,
            gap: rows::gap(parameters)?,
            stiffness: rows::stiffness(parameters)?,
            impedance: rows::impedance(parameters)?,
            motion: rows::motion(parameters)?,
            friction: rows::friction(parameters)?,
        })
    }

    pub(super) fn write(&self, folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
        Ok(vec![
            table(
                folder,
                "fig03_impedance_by_stiffness.csv",
                &self.impedance_by_stiffness,
            )?,
            table(folder, "fig05a_force_left_to_film.csv", &self.balance)?,
            table(folder, "fig05a_film_force.csv", &self.squeeze)?,
            table(folder, "fig05b_gap.csv", &self.gap)?,
            table(folder, "fig06_stiffness.csv", &self.stiffness)?,
            table(folder, "fig07b_impedance.csv", &self.impedance)?,
            table(folder, "fig08_motion.csv", &self.motion)?,
            table(folder, "fig09_friction.csv", &self.friction)?,
        ])
    }
}

fn table<R: Serialize>(folder: &Path, name: &str, rows: &[R]) -> anyhow::Result<PathBuf> {
    let path = folder.join(name);
    let write = || -> anyhow::Result<()> {
        let mut writer = csv::Writer::from_writer(std::fs::File::create(&path)?);
        for row in rows {
            writer.serialize(row)?;
        }
        Ok(writer.flush()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}
