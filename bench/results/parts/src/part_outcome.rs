//! Outcomes of recordings of a call for parts.

use std::path::{Path, PathBuf};

use analysis::RecordingAnalysis;

use crate::key::Key;
use crate::layout::Place;

/// State of a part after a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartState {
    /// The recording was analysed.
    Done,
    /// The part was there already.
    Kept,
    /// The recording cannot be analysed, and has no part.
    Failed,
    /// The recording is no longer in the study, and its part was removed.
    Removed,
    /// The recording is no longer in the study, but its part is of another laboratory and stays.
    Foreign,
}

impl PartState {
    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Kept => "kept",
            Self::Failed => "failed",
            Self::Removed => "removed",
            Self::Foreign => "foreign",
        }
    }
}

/// Outcome of a recording.
#[derive(Debug)]
pub struct PartOutcome {
    /// Folder of the recording, as given.
    pub path: PathBuf,
    /// State of its part.
    pub state: PartState,
    /// Key of its part; `None` if its files cannot be read.
    pub key: Option<Key>,
    /// Files that no longer have the sum in the session's log.
    pub changed: Vec<PathBuf>,
    /// Analysis; `None` if the part was there already, or if the files cannot be read.
    pub analysis: Option<RecordingAnalysis>,
    /// Reason why the files cannot be read.
    pub unread: Option<String>,
    /// Remedy of a part that stays though its recording does not.
    pub remedy: Option<String>,
}

impl PartOutcome {
    pub(crate) fn new(path: &Path, state: PartState) -> Self {
        Self {
            path: path.to_owned(),
            state,
            key: None,
            changed: Vec::new(),
            analysis: None,
            unread: None,
            remedy: None,
        }
    }

    /// Returns the outcome of a part whose recording is no longer in the study.
    pub(crate) fn lost_part(path: &Path, state: PartState, place: &Place) -> Self {
        Self {
            key: Some(place.key.clone()),
            ..Self::new(path, state)
        }
    }
}
