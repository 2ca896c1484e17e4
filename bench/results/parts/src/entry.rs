//! The entry of a recording in a folder of parts.

use std::path::{Path, PathBuf};

use analysis::people::Person;
use serde::{Deserialize, Serialize};

use crate::inputs::Input;
use crate::layout::Place;

/// Verdict on a recording, in the rows of its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Verdict {
    /// Whether the session's log accepted the attempt.
    pub(crate) is_accepted: bool,
    /// Whether the study excludes it, and it is analysed all the same.
    pub(crate) is_excluded: bool,
}

/// A recording in a folder of parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// Canonical path of its folder; `None` in an entry of an early version.
    #[serde(default)]
    pub(crate) recording: Option<PathBuf>,
    /// Verdict in the rows of its part; `None` in an entry of an early version.
    #[serde(default)]
    pub(crate) verdict: Option<Verdict>,
    /// Folder of its study; `None` outside any.
    pub(crate) study: Option<PathBuf>,
    /// Pseudonym of its participant, unique in the study.
    pub(crate) participant: Option<String>,
    /// Its files.
    pub(crate) inputs: Vec<Input>,
    /// Place of its part, or the reason why it cannot be analysed.
    pub(crate) part: Result<Place, String>,
}

impl Entry {
    /// Returns the folder of the recording, or of its study if only that is known.
    pub(crate) fn folder(&self) -> Option<&Path> {
        self.recording.as_deref().or(self.study.as_deref())
    }

    /// Returns the folder of the session, if known.
    pub(crate) fn session(&self) -> Option<&Path> {
        self.recording.as_deref()?.parent()
    }

    /// Returns whether the rows of the part say this verdict.
    pub(crate) fn has_verdict(&self, verdict: Verdict) -> bool {
        self.verdict
            .map_or(!verdict.is_excluded, |known| known == verdict)
    }

    /// Returns the person, if known.
    pub(crate) fn person(&self) -> Option<Person> {
        Some((self.study.clone(), self.participant.clone()?))
    }
}
