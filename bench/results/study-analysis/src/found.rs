//! Recordings found for an analysis.

use std::path::{Path, PathBuf};

use attempts::{Attempts, SelectedAttempt};
use study::exclusions::RecordingSelection;

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
}
