//! The entry of a recording in a folder of parts.

use std::path::PathBuf;

use analysis::people::Person;
use serde::{Deserialize, Serialize};

use crate::inputs::Input;
use crate::layout::Place;

/// A recording in a folder of parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Entry {
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
    /// Returns the person, if known.
    pub(crate) fn person(&self) -> Option<Person> {
        Some((self.study.clone(), self.participant.clone()?))
    }
}
