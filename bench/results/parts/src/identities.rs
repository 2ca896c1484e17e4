//! Attempts of recordings, by which different calls find the same one.

use std::path::{Path, PathBuf};

use recording::reader::read_manifest;
use serde::{Deserialize, Serialize};
use study::exclusions::study_of;
use study::identity::RecordingIdentity;

use crate::entry::Entry;
use crate::inputs::Input;
use crate::layout::Layout;
use crate::parts_error::PartsError;
use crate::stored_file::read_value;

/// Attempt at a trial within a study: two recordings of it with different contents cannot both count.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct AttemptInStudy {
    /// Folder of the study.
    study: PathBuf,
    /// Participant, session, trial and attempt.
    pub(crate) identity: RecordingIdentity,
}

impl AttemptInStudy {
    /// Reads the attempt of a recording; `None` outside a study, or if its description names no participant or no trial.
    pub(crate) fn read(recording: &Path) -> Option<Self> {
        Some(Self {
            study: study_of(recording)?,
            identity: RecordingIdentity::from_manifest(&read_manifest(recording).ok()?)?,
        })
    }
}

/// Returns whether two recordings with these canonical paths have equal files. Those without a part yet count as equal: their lack is
/// found later.
///
/// # Errors
/// The index is damaged.
pub(crate) fn has_equal_inputs(
    layout: &Layout,
    recordings: [&PathBuf; 2],
) -> Result<bool, PartsError> {
    let [one, other] = recordings.map(|recording| read_value::<Entry>(&layout.entry(recording)));
    let sums = |inputs: &[Input]| -> Vec<(String, String)> {
        let inputs = inputs.iter();
        inputs
            .map(|input| (input.name.clone(), input.sum.clone()))
            .collect()
    };
    Ok(match (one?, other?) {
        (Some(one), Some(other)) => sums(&one.inputs) == sums(&other.inputs),
        _ => true,
    })
}
