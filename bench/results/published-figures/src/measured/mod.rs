//! Figures of measurements: friction and its fall of each participant, Huloux 2021, Figs. 11, 13, 14 and 15, and the shift of the
//! plate's resonance.
//!
//! [`measured_figures`] draws the figures that an analysis allows, [`write_figures`] writes them with their data.

mod agreement;
mod elements;
mod figure_selection;
mod instances;
mod resonance_shift;
mod typical_trial;
mod variation;

use std::path::{Path, PathBuf};

use analysis::estimate::Method;
use analysis::findings::{Analysis, RecordingFindings};
use analysis::{SeriesError, SeriesSource};
use descriptive::Description;
use descriptive::figure::figure;
use plotting::Figure;
use study::sessions::Sessions;

pub use figure_selection::FigureSelection;

/// Returns the figures that these recordings allow: without an instance, only the trial in time; without an exploration,
/// no figure. `trial` is drawn for recordings with a usable fit. `sessions` gives the time between recordings.
///
/// # Errors
/// The series cannot be read.
pub fn measured_figures(
    (analysed, series): (&Analysis, &dyn SeriesSource),
    sessions: &Sessions,
    selection: &FigureSelection,
) -> Result<Vec<Figure>, SeriesError> {
    let selection = &selection.available_in(analysed);
    let mut figures: Vec<Figure> = figure(&Description::new(analysed)).into_iter().collect();
    if let Some((number, typical_recording)) = typical_recording(analysed) {
        let recording = series.read(number)?;
        figures.extend(typical_trial::figure(
            typical_recording,
            &recording,
            analysed,
            selection,
        ));
        figures.extend(instances::figure(
            typical_recording,
            &recording,
            analysed,
            selection,
        ));
    }
    if analysed.instances().next().is_some() && !selection.methods.is_empty() {
        figures.push(variation::figure(analysed, selection));
        figures.push(agreement::figure((analysed, series), selection)?);
    }
    figures.extend(resonance_shift::figures(analysed, sessions, selection));
    if let Some(line) = analysed.provenance().line() {
        for figure in &mut figures {
            figure.caption += &format!(" Recordings: {line}.");
            figure.footnote = Some(format!("Recordings: {line}"));
        }
    }
    Ok(figures)
}

/// Returns the recording with the median of the mean σ_t by the dynamic method (the lower of two); without instances, the
/// first readable recording.
fn typical_recording(analysed: &Analysis) -> Option<(usize, &RecordingFindings)> {
    let mut mean_sigmas: Vec<(f64, (usize, &RecordingFindings))> = analysed
        .numbered_findings()
        .filter_map(|(number, findings)| {
            let estimates = findings
                .instances
                .iter()
                .filter_map(|i| i.estimate_by(Method::Dynamic));
            let sigmas_m: Vec<f64> = estimates
                .map(|estimate| estimate.estimate.sigma_t_m())
                .collect();
            let mean_m = sigmas_m.iter().sum::<f64>() / sigmas_m.len() as f64;
            mean_m.is_finite().then_some((mean_m, (number, findings)))
        })
        .collect();
    mean_sigmas.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = mean_sigmas.len().saturating_sub(1) / 2;
    mean_sigmas
        .get(median)
        .map(|(_, recording)| *recording)
        .or_else(|| analysed.numbered_findings().next())
}

/// Reasons why the figures of an analysis cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// The series cannot be read.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// A figure cannot be drawn or written.
    #[error(transparent)]
    Figure(#[from] plotting::FigureError),
}

/// Draws the figures of an analysis and writes them as [`plotting::write()`] does, each with its data as CSV, into a
/// folder, which is created if missing.
///
/// # Errors
/// The series cannot be read, a figure cannot be drawn or a file cannot be written.
pub fn write_figures(
    analysed: (&Analysis, &dyn SeriesSource),
    sessions: &Sessions,
    selection: &FigureSelection,
    folder: &Path,
) -> Result<Vec<PathBuf>, MeasuredError> {
    std::fs::create_dir_all(folder).map_err(|source| plotting::FigureError::Write {
        path: folder.to_owned(),
        source,
    })?;
    let figures = measured_figures(analysed, sessions, selection)?;
    let mut paths = plotting::write(&figures, folder)?;
    for figure in &figures {
        let path = folder.join(format!("{}.csv", figure.name));
        std::fs::write(&path, figure.to_csv()).map_err(|source| plotting::FigureError::Write {
            path: path.clone(),
            source,
        })?;
        paths.push(path);
    }
    Ok(paths)
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
