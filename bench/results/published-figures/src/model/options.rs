//! Options of `friction-bench model`.

use std::path::PathBuf;

use clap::Args;
use contact::AssumedConstants;

/// Options of `model`.
#[derive(Debug, Args)]
pub struct ModelOptions {
    /// Folder for the files; created if it does not exist.
    #[arg(long, value_name = "DIR", default_value = "model")]
    pub out: PathBuf,
    /// Write the curves only, no figures.
    #[arg(long)]
    pub csv_only: bool,
    /// Values that the model assumes.
    #[command(flatten)]
    pub assume: Assumptions,
}

/// Values assumed for the model's curves; the defaults are those of the published figures where they are stated.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Assumptions")]
pub struct Assumptions {
    /// σ_t, characteristic height of the asperities, m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().sigma_t_m)]
    pub sigma_t_m: f64,
    /// S, apparent contact area, m².
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().contact_area_m2)]
    pub contact_area_m2: f64,
    /// E, Young's modulus of the skin, Pa.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().young_modulus_pa)]
    pub young_modulus_pa: f64,
    /// ν, Poisson's ratio of the skin.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = Self::default().poisson_ratio)]
    pub poisson_ratio: f64,
    /// q0, wave vector of the coarsest roughness, rad/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().q0_rad_per_m)]
    pub q0_rad_per_m: f64,
    /// p0, ambient pressure, Pa.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().ambient_pressure_pa)]
    pub ambient_pressure_pa: f64,
    /// η, loss factor of the contact.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = Self::default().loss_factor)]
    pub loss_factor: f64,
    /// f0, carrier and resonance of the plate, Hz.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().carrier_hz)]
    pub carrier_hz: f64,
    /// m_p, modal mass of the plate, kg.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().plate_mass_kg)]
    pub plate_mass_kg: f64,
    /// b_p, damping of the plate, N·s/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().plate_damping_n_s_per_m)]
    pub plate_damping_n_s_per_m: f64,
    /// m_t, mass of the skin, kg.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = Self::default().tissue_mass_kg)]
    pub tissue_mass_kg: f64,
    /// k_t, stiffness of the skin, N/m.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = Self::default().tissue_stiffness_n_per_m)]
    pub tissue_stiffness_n_per_m: f64,
    /// b_t, damping of the skin, N·s/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().tissue_damping_n_s_per_m)]
    pub tissue_damping_n_s_per_m: f64,
    /// μ0, friction without vibration.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = Self::default().mu0)]
    pub mu0: f64,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self {
            sigma_t_m: 2e-6,
            contact_area_m2: AssumedConstants::FIGURES.contact_area_m2,
            young_modulus_pa: AssumedConstants::FIGURES.young_modulus_pa,
            poisson_ratio: AssumedConstants::FIGURES.poisson_ratio,
            q0_rad_per_m: AssumedConstants::FIGURES.q0_rad_per_m,
            ambient_pressure_pa: AssumedConstants::FIGURES.ambient_pressure_pa,
            loss_factor: AssumedConstants::FIGURES.loss_factor,
            carrier_hz: 35e3,
            plate_mass_kg: 8e-3,
            plate_damping_n_s_per_m: 7.01,
            tissue_mass_kg: 1e-4,
            tissue_stiffness_n_per_m: 0.0,
            tissue_damping_n_s_per_m: 32.0,
            mu0: 0.8,
        }
    }
}

fn number(text: &str, is_allowed: fn(f64) -> bool, limit: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if is_allowed(value) => Ok(value),
        _ => Err(format!("must be {limit}")),
    }
}

/// Parses a finite number above 0 for a command-line option.
///
/// # Errors
/// The text is not a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(
        text,
        |value| value.is_finite() && value > 0.0,
        "a finite number above 0",
    )
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(
        text,
        |value| value.is_finite() && value >= 0.0,
        "a finite number from 0",
    )
}
