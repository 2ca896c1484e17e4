//! Figures of measurements: Huloux 2021, Figs. 11, 13, 14 and 15, and the shift of the plate's resonance.
//!
//! [`measured_figures`] draws the figures that an analysis allows, [`write_figures`] writes them with their data.

mod agreement;
mod drawn;
mod elements;
mod instances;
mod resonance_shift;
mod typical_trial;
mod variation;

use std::path::{Path, PathBuf};

use analysis::analysed::{Analysed, RecordingFindings};
use analysis::estimate::Method;
use figures::Figure;
use sessions::Sessions;

pub use drawn::Drawn;

/// Returns the figures that these recordings allow: without an instance, only the trial in time; without an exploration,
/// no figure. `trial` is drawn for recordings with a usable fit. `sessions` gives the time between recordings.
pub fn measured_figures(analysed: &Analysed, sessions: &Sessions, drawn: &Drawn) -> Vec<Figure> {
    let drawn = &drawn.found_in(analysed);
    let mut figures = Vec::new();
    if let Some(typical) = typical(analysed) {
        figures.extend(typical_trial::figure(typical, &analysed.settings, drawn));
        figures.extend(instances::figure(typical, &analysed.settings, drawn));
    }
    if analysed.instances().next().is_some() && !drawn.methods.is_empty() {
        figures.push(variation::figure(analysed, drawn));
        figures.push(agreement::figure(analysed, drawn));
    }
    figures.extend(resonance_shift::figures(analysed, sessions, drawn));
    figures
}

/// Returns the recording with the median of the mean σ_t by the dynamic method (the lower of two); without instances, the
/// first readable recording.
fn typical(analysed: &Analysed) -> Option<&RecordingFindings> {
    let mut by_sigma: Vec<(f64, &RecordingFindings)> = analysed
        .findings()
        .filter_map(|found| {
            let usable = found
                .instances
                .iter()
                .filter_map(|i| i.estimated(Method::Dynamic));
            let sigmas_m: Vec<f64> = usable.map(|of| of.sigma_t_m).collect();
            let mean_m = sigmas_m.iter().sum::<f64>() / sigmas_m.len() as f64;
            mean_m.is_finite().then_some((mean_m, found))
        })
        .collect();
    by_sigma.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = by_sigma.len().saturating_sub(1) / 2;
    by_sigma
        .get(median)
        .map(|(_, found)| *found)
        .or_else(|| analysed.findings().next())
}

/// Draws the figures of an analysis and writes them as [`figures::write()`] does, each with its data as CSV, into a
/// folder, which is created if missing.
///
/// # Errors
/// A figure cannot be drawn or a file cannot be written.
pub fn write_figures(
    analysed: &Analysed,
    sessions: &Sessions,
    drawn: &Drawn,
    folder: &Path,
) -> Result<Vec<PathBuf>, figures::FigureError> {
    std::fs::create_dir_all(folder).map_err(|source| figures::FigureError::Write {
        path: folder.to_owned(),
        source,
    })?;
    let drawn = measured_figures(analysed, sessions, drawn);
    let mut written = figures::write(&drawn, folder)?;
    for figure in &drawn {
        let path = folder.join(format!("{}.csv", figure.name));
        std::fs::write(&path, figure.to_csv()).map_err(|source| figures::FigureError::Write {
            path: path.clone(),
            source,
        })?;
        written.push(path);
    }
    Ok(written)
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
