//! What a report is made of.

use std::path::Path;

use figures::{Figure, FigureError};
use jiff::Timestamp;
use recording::Manifest;
use sessions::{Attempt, Sessions};

use crate::results::{Recording, Results};

/// Content of a report.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// Name of what was analysed.
    pub name: &'a str,
    /// The results as `analyze --json` writes them.
    pub results: &'a str,
    /// Their recordings, in the same order.
    pub recordings: &'a [Recorded<'a>],
    /// Sessions that the recordings are of.
    pub sessions: &'a Sessions,
    /// Figures.
    pub figures: &'a [Figure],
    /// Date of the report.
    pub made: Timestamp,
    /// Name and version of the program.
    pub program: &'a str,
}

/// A recording of the results.
#[derive(Debug, Clone, Copy)]
pub struct Recorded<'a> {
    /// Its folder.
    pub path: &'a Path,
    /// Its description; `None` if it cannot be read.
    pub manifest: Option<&'a Manifest>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The results are not as their schema has them.
    #[error("the results cannot be read back: {0}")]
    Results(#[from] serde_json::Error),
    /// There are not as many recordings as results.
    #[error("{recordings} recordings beside results of {results}")]
    Recordings {
        /// Recordings given.
        recordings: usize,
        /// Recordings in the results.
        results: usize,
    },
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// A recording with everything that is known of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Of<'a> {
    /// Number in the report, from 1.
    pub(crate) number: usize,
    pub(crate) path: &'a Path,
    pub(crate) manifest: Option<&'a Manifest>,
    pub(crate) attempt: Option<&'a Attempt>,
    pub(crate) result: &'a Recording,
}

/// Returns the recordings with all that is known of each.
pub(crate) fn all_of<'a>(
    content: &Content<'a>,
    results: &'a Results,
) -> Result<Vec<Of<'a>>, ReportError> {
    if content.recordings.len() != results.recordings.len() {
        return Err(ReportError::Recordings {
            recordings: content.recordings.len(),
            results: results.recordings.len(),
        });
    }
    let each = content.recordings.iter().zip(&results.recordings).zip(1..);
    let each = each.map(|((recorded, result), number)| Of {
        number,
        path: recorded.path,
        manifest: recorded.manifest,
        attempt: content.sessions.attempt(recorded.path),
        result,
    });
    Ok(each.collect())
}

impl<'a> Of<'a> {
    /// Returns the name of the place on the page where its estimates are.
    pub(crate) fn anchor(&self) -> String {
        format!("recording-{}", self.number)
    }

    /// Returns who the recording is of and which trial it is; or else the name of its folder, without where that lies.
    pub(crate) fn name(&self) -> String {
        let known = || {
            let manifest = self.manifest?;
            let (participant, trial) = (manifest.participant.as_ref()?, manifest.trial.as_ref()?);
            let practice = if trial.practice { "practice " } else { "" };
            Some(format!(
                "{}, session {}, {practice}trial {}, attempt {}",
                self.participant().unwrap_or(&participant.id),
                participant.session,
                trial.number,
                trial.attempt
            ))
        };
        known().unwrap_or_else(|| {
            let name = self.path.file_name().unwrap_or(self.path.as_os_str());
            name.to_string_lossy().into_owned()
        })
    }

    pub(crate) fn is_uncalibrated(&self) -> bool {
        let hardware = self
            .manifest
            .and_then(|manifest| manifest.hardware.as_ref());
        hardware.is_some_and(|hardware| hardware.uncalibrated)
    }

    pub(crate) fn participant(&self) -> Option<&'a str> {
        self.result.participant.as_deref()
    }
}
