//! From recordings to impedance, gap and friction.
//!
//! [`demodulated`] streams a recording folder through the demodulator that also runs live, [`unloaded`] takes the plate's own
//! impedance, [`trial_selection`] and the `protocols` crate choose the instances, [`estimate`] estimates each by both methods. [`analyse`] does it for any number of
//! recordings at once, [`results`] writes what came out.

pub mod analysed;
pub mod analysis_settings;
mod clipping;
pub mod demodulated;
pub mod estimate;
pub mod exploration_findings;
pub mod find;
pub mod flaw;
mod free_plate;
pub mod instance;
mod levels;
pub mod live_contact;
mod measured_figures;
pub mod measurements;
pub mod model_check;
pub mod published;
pub mod recording_analysis;
pub mod results;
pub mod statistics;
pub mod tables;
pub mod trial_fit;
pub mod trial_selection;
pub mod unloaded;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use analysed::{Analysed, RecordingAnalysis};
pub use analysis_settings::Settings;
pub use measured_figures::measured_figures;

/// Analyses recording folders in parallel, in the given order; `finished` is called as each is done. A recording that cannot
/// be read does not stop the others.
pub fn analyse(
    folders: &[PathBuf],
    settings: &Settings,
    finished: impl Fn(&RecordingAnalysis) + Sync,
) -> Analysed {
    let recordings = folders
        .par_iter()
        .map(|folder| {
            let analysis = recording_analysis::analyse(folder, settings);
            finished(&analysis);
            analysis
        })
        .collect();
    Analysed {
        settings: *settings,
        recordings,
    }
}

/// Draws what an analysis found and writes it into a folder that is made if it is not there, as [`figures::write()`] does.
///
/// # Errors
/// If a figure cannot be drawn or a file cannot be written.
pub fn write_figures(
    analysed: &Analysed,
    folder: &Path,
) -> Result<Vec<PathBuf>, figures::FigureError> {
    std::fs::create_dir_all(folder).map_err(|source| figures::FigureError::Write {
        path: folder.to_owned(),
        source,
    })?;
    figures::write(&measured_figures(analysed), folder)
}
