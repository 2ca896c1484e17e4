//! Curves of the published contact model, without any measurement: `friction-bench model`.

mod curves;
mod figures;
mod options;
mod parameters;
mod rows;

use std::fs;
use std::path::PathBuf;

use anyhow::Context;

pub use curves::Curves;
pub use figures::draw;
pub use options::{Assumptions, ModelOptions, positive};
pub use parameters::ModelParameters;
pub use rows::{
    Balance, ContactMotion, Friction, Gap, Impedance, ImpedanceByStiffness, Squeeze, Stiffness,
};

/// Writes the curves and, unless disabled, the figures with their captions into a folder, which is created if missing.
///
/// # Errors
/// A parameter has no physical meaning or a file cannot be written.
pub fn run(options: &ModelOptions) -> anyhow::Result<Vec<PathBuf>> {
    let parameters = ModelParameters::from(&options.assume);
    let curves = Curves::compute(&parameters)?;
    fs::create_dir_all(&options.out)
        .with_context(|| format!("cannot make the folder {}", options.out.display()))?;
    let mut paths = curves.write(&options.out)?;
    if !options.csv_only {
        paths.extend(plotting::write(&draw(&parameters, &curves), &options.out)?);
    }
    Ok(paths)
}
