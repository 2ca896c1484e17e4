//! Recordings found for an analysis.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use analysis::attempts::{Attempts, SelectedAttempt};
use analysis::{RecordingAnalysis, Settings, analyse_while};
use study::exclusions::{ExclusionsError, RecordingSelection};

use crate::study_analysis::StudyAnalysis;

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
    /// The exclusions of a study cannot be read.
    pub fn analyse(
        self,
        settings: &Settings,
        callback: impl Fn(&RecordingAnalysis) -> ControlFlow<()> + Sync,
    ) -> Result<Option<StudyAnalysis>, ExclusionsError> {
        let analysed = analyse_while(self.recordings(), settings, callback);
        analysed
            .map(|analysed| StudyAnalysis::new(self, analysed))
            .transpose()
    }
}
