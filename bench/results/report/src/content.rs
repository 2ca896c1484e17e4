//! Content of a report.

use std::path::Path;

use jiff::Timestamp;
use plotting::{Figure, FigureError};
use recording::Manifest;
use study::sessions::{Attempt, Sessions};

use crate::recording_results::Recording;
use crate::results::Results;

/// Content of a report.
#[derive(Debug, Clone, Copy)]
pub struct ReportContent<'a> {
    /// Name of the analysed study.
    pub name: &'a str,
    /// Results.
    pub results: &'a Results<'a>,
    /// Recordings, in the order of the analysis.
    pub recordings: &'a [Recorded<'a>],
    /// Sessions of the recordings.
    pub sessions: &'a Sessions,
    /// Figures.
    pub figures: &'a [Figure],
    /// Date of the report.
    pub date: Timestamp,
    /// Name and version of the program.
    pub program: &'a str,
}

/// Recording of the report.
#[derive(Debug, Clone, Copy)]
pub struct Recorded<'a> {
    /// Folder.
    pub path: &'a Path,
    /// Description; `None` if it cannot be read.
    pub manifest: Option<&'a Manifest>,
    /// Results.
    pub result: &'a Recording,
}

/// Error of making a report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// Recording with its results, description and attempt.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RecordingEntry<'a> {
    /// Number in the report, from 1.
    pub(crate) number: usize,
    pub(crate) path: &'a Path,
    pub(crate) manifest: Option<&'a Manifest>,
    pub(crate) attempt: Option<&'a Attempt>,
    pub(crate) result: &'a Recording,
}

/// Returns the recordings, each with its attempt.
pub(crate) fn recording_entries<'a>(content: &ReportContent<'a>) -> Vec<RecordingEntry<'a>> {
    let entries = content.recordings.iter().zip(1..);
    let entries = entries.map(|(recorded, number)| RecordingEntry {
        number,
        path: recorded.path,
        manifest: recorded.manifest,
        attempt: content.sessions.attempt(recorded.path),
        result: recorded.result,
    });
    entries.collect()
}

impl<'a> RecordingEntry<'a> {
    /// Returns the anchor of its estimates on the page.
    pub(crate) fn anchor(&self) -> String {
        format!("recording-{}", self.number)
    }

    /// Returns participant, session and trial of the recording, or else the name of its folder, without the path.
    pub(crate) fn name(&self) -> String {
        let trial_name = || {
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
        trial_name().unwrap_or_else(|| {
            let name = self.path.file_name().unwrap_or(self.path.as_os_str());
            name.to_string_lossy().into_owned()
        })
    }

    pub(crate) fn participant(&self) -> Option<&'a str> {
        self.result.participant.as_deref()
    }
}
