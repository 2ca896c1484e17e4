//! The published contact model as curves, without any measurement: `friction-bench model`.

mod curves;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use contact::harmonic::Resonator;
use contact::{AssumedConstants, Contact, ModelError};
use num_complex::Complex64;
use serde::Serialize;

use crate::cli::{self, ModelAssumptions};
use crate::figures;

pub use curves::{
    Balance, Friction, Gap, Impedance, ImpedanceByStiffness, Motion, Squeeze, Stiffness,
};

/// Everything that the model's curves assume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Finger and air.
    pub assumed: AssumedConstants,
    /// σ_t, m.
    pub sigma_t_m: f64,
    /// f0, Hz: carrier and resonance.
    pub carrier_hz: f64,
    /// m_p, kg.
    pub plate_mass_kg: f64,
    /// b_p, N·s/m.
    pub plate_damping_n_s_per_m: f64,
    /// m_t, k_t and b_t.
    pub tissue: Resonator,
    /// μ0.
    pub mu0: f64,
}

impl From<&ModelAssumptions> for Parameters {
    fn from(options: &ModelAssumptions) -> Self {
        Self {
            assumed: AssumedConstants {
                q0_rad_per_m: options.q0_rad_per_m,
                poisson_ratio: options.poisson_ratio,
                young_modulus_pa: options.young_modulus_pa,
                contact_area_m2: options.contact_area_m2,
                ambient_pressure_pa: options.ambient_pressure_pa,
                loss_factor: options.loss_factor,
            },
            sigma_t_m: options.sigma_t_m,
            carrier_hz: options.carrier_hz,
            plate_mass_kg: options.plate_mass_kg,
            plate_damping_n_s_per_m: options.plate_damping_n_s_per_m,
            tissue: Resonator {
                mass_kg: options.tissue_mass_kg,
                stiffness_n_per_m: options.tissue_stiffness_n_per_m,
                damping_n_s_per_m: options.tissue_damping_n_s_per_m,
            },
            mu0: options.mu0,
        }
    }
}

impl Parameters {
    fn carrier_rad_per_s(&self) -> f64 {
        std::f64::consts::TAU * self.carrier_hz
    }

    fn contact(&self) -> Result<Contact, ModelError> {
        Contact::new(&self.assumed, self.sigma_t_m)
    }

    /// k_p = (2π f0)² m_p: the plate is driven at its resonance.
    fn plate(&self) -> Resonator {
        Resonator {
            mass_kg: self.plate_mass_kg,
            stiffness_n_per_m: self.carrier_rad_per_s().powi(2) * self.plate_mass_kg,
            damping_n_s_per_m: self.plate_damping_n_s_per_m,
        }
    }

    /// Z_p at the carrier.
    fn z_p(&self) -> Complex64 {
        self.plate().impedance_n_s_per_m(self.carrier_rad_per_s())
    }

    /// Z_t at the carrier.
    pub fn z_t_n_s_per_m(&self) -> Complex64 {
        self.tissue.impedance_n_s_per_m(self.carrier_rad_per_s())
    }
}

/// Writes the curves, and unless told otherwise the figures with their captions, into a folder that is made if it is not there.
///
/// # Errors
/// If a parameter has no physical meaning or a file cannot be written.
pub fn run(options: &cli::Model) -> anyhow::Result<Vec<PathBuf>> {
    let parameters = Parameters::from(&options.assume);
    let curves = Curves::compute(&parameters)?;
    fs::create_dir_all(&options.out)
        .with_context(|| format!("cannot make the folder {}", options.out.display()))?;
    let mut written = curves.write(&options.out)?;
    if !options.csv_only {
        written.extend(figures::write(
            &figures::model(&parameters, &curves),
            &options.out,
        )?);
    }
    Ok(written)
}

/// The curves of all figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Fig. 3: Z_m and |ṽ_t/ṽ_p| against k_c.
    pub impedance_by_stiffness: Vec<ImpedanceByStiffness>,
    /// Fig. 5a: what the asperities leave to the film.
    pub balance: Vec<Balance>,
    /// Fig. 5a: what the film carries.
    pub squeeze: Vec<Squeeze>,
    /// Fig. 5b: gap against amplitude and force.
    pub gap: Vec<Gap>,
    /// Fig. 6: k_c against amplitude and force.
    pub stiffness: Vec<Stiffness>,
    /// Fig. 7b: Z_m against amplitude and force.
    pub impedance: Vec<Impedance>,
    /// Fig. 8: plate and skin in time.
    pub motion: Vec<Motion>,
    /// Fig. 9: μ against amplitude and force.
    pub friction: Vec<Friction>,
}

impl Curves {
    /// # Errors
    /// If a parameter has no physical meaning.
    pub fn compute(parameters: &Parameters) -> Result<Self, ModelError> {
        Ok(Self {
            impedance_by_stiffness: curves::impedance_by_stiffness(parameters),
            balance: curves::balance(parameters)?,
            squeeze: curves::squeeze(parameters)?,
            gap: curves::gap(parameters)?,
            stiffness: curves::stiffness(parameters)?,
            impedance: curves::impedance(parameters)?,
            motion: curves::motion(parameters)?,
            friction: curves::friction(parameters)?,
        })
    }

    fn write(&self, folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
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
        let mut writer = csv::Writer::from_path(&path)?;
        for row in rows {
            writer.serialize(row)?;
        }
        Ok(writer.flush()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}
