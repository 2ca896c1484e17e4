//! Assumptions of the model's curves.

use contact::harmonic::Resonator;
use contact::{AssumedConstants, Contact, ModelError};
use num_complex::Complex64;

use crate::model::options::Assumptions;

/// Parameters of the model's curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelParameters {
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

impl From<&Assumptions> for ModelParameters {
    fn from(options: &Assumptions) -> Self {
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

impl ModelParameters {
    pub(super) fn carrier_rad_per_s(&self) -> f64 {
        std::f64::consts::TAU * self.carrier_hz
    }

    pub(super) fn contact(&self) -> Result<Contact, ModelError> {
        Contact::new(&self.assumed, self.sigma_t_m)
    }

    /// k_p = (2π f0)² m_p: the plate is driven at its resonance.
    pub(super) fn plate(&self) -> Resonator {
        Resonator {
            mass_kg: self.plate_mass_kg,
            stiffness_n_per_m: self.carrier_rad_per_s().powi(2) * self.plate_mass_kg,
            damping_n_s_per_m: self.plate_damping_n_s_per_m,
        }
    }

    /// Z_p at the carrier.
    pub(super) fn z_p(&self) -> Complex64 {
        self.plate().impedance_n_s_per_m(self.carrier_rad_per_s())
    }

    /// Z_t at the carrier.
    pub fn z_t_n_s_per_m(&self) -> Complex64 {
        self.tissue.impedance_n_s_per_m(self.carrier_rad_per_s())
    }
}
