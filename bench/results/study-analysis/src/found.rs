//! Recordings found for an analysis.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use analysis::{RecordingAnalysis, SeriesError, Settings, analyse_into};
use attempts::{Attempts, SelectedAttempt};
use series_spool::SeriesSpool;
use study::exclusions::{ExclusionsError, RecordingSelection};

use crate::study_analysis::StudyAnalysis;

/// Reasons why the recordings found cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The exclusions of a study cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
    /// The time series cannot be kept.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

/// Recordings found for an analysis.
#[derive(Debug, Default)]
pub struct Found {
    /// Name of the analysed study, or of the recordings.
    pub name: String,
    /// Attempts found, with their standing.
    pub attempts: Attempts,
    /// Recordings to analyse, and the exclusions.
    pub selection: RecordingSelection,
}

impl Found {
    /// Returns a recording that was found without a search, such as one in memory.
    #[must_use]
    pub fn one(path: &Path) -> Self {
        Self {
            name: path.display().to_string(),
            attempts: Attempts {
                selection: vec![SelectedAttempt {
                    path: path.to_owned(),
                    standing: None,
                }],
                ..Attempts::default()
            },
            selection: RecordingSelection {
                recordings: vec![path.to_owned()],
                ..RecordingSelection::default()
            },
        }
    }

    /// Returns the recordings to analyse.
    #[must_use]
    pub fn recordings(&self) -> &[PathBuf] {
        &self.selection.recordings
    }

    /// Analyses the recordings; `callback` is called after each one, from several threads. Returns `None` once `callback` broke
    /// off.
    ///
    /// # Errors
    /// The exclusions of a study cannot be read, or the time series cannot be kept.
    pub fn analyse(
        self,
        settings: &Settings,
        callback: impl Fn(&RecordingAnalysis) -> ControlFlow<()> + Sync,
    ) -> Result<Option<StudyAnalysis>, AnalysisError> {
        let spool = SeriesSpool::default();
        let analysed = analyse_into(&spool, self.recordings(), settings, callback)?;
        let study = analysed.map(|analysed| StudyAnalysis::new(self, (analysed, spool)));
        Ok(study.transpose()?)
    }
}
