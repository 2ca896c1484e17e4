//! Request for an analysis: folders, and the recordings in them that count.

use std::path::PathBuf;

use attempts::find::{self, FindError, TrialFilter};
use study::exclusions::{self, EXCLUSIONS_FILE, ExclusionsError};

use crate::found::Found;

/// Request for an analysis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Request {
    /// Folders of recordings, or of studies, participants or sessions.
    pub folders: Vec<PathBuf>,
    /// Trials to analyse in addition to the accepted ones.
    pub filter: TrialFilter,
    /// Whether the recordings that a study's exclusions leave out are analysed too.
    pub include_excluded: bool,
    /// Folders of recordings to leave out.
    pub exceptions: Vec<PathBuf>,
}

/// Reasons why a request has nothing to analyse.
#[derive(Debug, thiserror::Error)]
pub enum RequestError {
    /// The folders contain no recordings, or cannot be read.
    #[error(transparent)]
    Find(#[from] FindError),
    /// The exclusions of a study cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
    /// The exclusions leave out every recording.
    #[error(
        "nothing is left to analyse: {EXCLUSIONS_FILE} leaves out {list}; --include-excluded analyses it all the same"
    )]
    NothingLeft {
        /// Exclusions, joined by `; `.
        list: String,
    },
}

impl Request {
    /// Finds the recordings to analyse.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn find(&self) -> Result<Found, RequestError> {
        let attempts = find::attempts_except(&self.folders, self.filter, &self.exceptions)?;
        let recordings = attempts.recordings();
        let mut selection = exclusions::select(recordings.clone())?;
        if self.include_excluded {
            selection = selection.overridden(recordings);
        } else if selection.recordings.is_empty() {
            return Err(RequestError::NothingLeft {
                list: selection.lines().join("; "),
            });
        }
        Ok(Found {
            name: self.name(),
            attempts,
            selection,
        })
    }

    /// Returns the names of the folders, without their paths.
    fn name(&self) -> String {
        let names = self.folders.iter().map(|folder| {
            let path = folder.canonicalize().unwrap_or_else(|_| folder.clone());
            let name = path.file_name().unwrap_or(path.as_os_str());
            name.to_string_lossy().into_owned()
        });
        names.collect::<Vec<_>>().join(", ")
    }
}
