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
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 2e-6)]
    pub sigma_t_m: f64,
    /// S, apparent contact area, m².
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.contact_area_m2)]
    pub contact_area_m2: f64,
    /// E, Young's modulus of the skin, Pa.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.young_modulus_pa)]
    pub young_modulus_pa: f64,
    /// ν, Poisson's ratio of the skin.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.poisson_ratio)]
    pub poisson_ratio: f64,
    /// q0, wave vector of the coarsest roughness, rad/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.q0_rad_per_m)]
    pub q0_rad_per_m: f64,
    /// p0, ambient pressure, Pa.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.ambient_pressure_pa)]
    pub ambient_pressure_pa: f64,
    /// η, loss factor of the contact.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = AssumedConstants::FIGURES.loss_factor)]
    pub loss_factor: f64,
    /// f0, carrier and resonance of the plate, Hz.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 35e3)]
    pub carrier_hz: f64,
    /// m_p, modal mass of the plate, kg.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 8e-3)]
    pub plate_mass_kg: f64,
    /// b_p, damping of the plate, N·s/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 7.01)]
    pub plate_damping_n_s_per_m: f64,
    /// m_t, mass of the skin, kg.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = 1e-4)]
    pub tissue_mass_kg: f64,
    /// k_t, stiffness of the skin, N/m.
    #[arg(long, value_parser = not_negative, allow_negative_numbers = true, default_value_t = 0.0)]
    pub tissue_stiffness_n_per_m: f64,
    /// b_t, damping of the skin, N·s/m.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 32.0)]
    pub tissue_damping_n_s_per_m: f64,
    /// μ0, friction without vibration.
    #[arg(long, value_parser = positive, allow_negative_numbers = true, default_value_t = 0.8)]
    pub mu0: f64,
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
