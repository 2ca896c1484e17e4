//! Accepted trials with missing or damaged recordings.

use std::collections::BTreeSet;
use std::path::Path;

use crate::sessions::LoggedSession;
use recording::manifest::End;
use recording::reader::Warning;
use recording::study::{TrialBlock, TrialLabel};
use recording::{DiskError, RecordingReader};
use wav_files::WavWarning;

use crate::verification::defect::RecordingDefect;
use crate::verification::session_names::recordings;

/// Accepted trial with a recording that is incomplete on disk or has no samples.
#[derive(Debug, Clone, PartialEq)]
pub struct LostRecording {
    /// The attempt.
    pub label: TrialLabel,
    /// Defect of its recording.
    pub defect: RecordingDefect,
    /// Whether no later trial was accepted.
    pub is_last: bool,
}

/// Returns the accepted trials with lost recordings, in the order of the log. Practice trials are not data and are not
/// checked.
///
/// # Errors
/// The folder cannot be listed.
pub fn lost_recordings(
    folder: &Path,
    session: &LoggedSession,
) -> Result<Vec<LostRecording>, DiskError> {
    let folder_labels: BTreeSet<TrialLabel> = recordings(folder)?.into_iter().collect();
    let accepted_attempts = session.accepted();
    let accepted_labels: Vec<TrialLabel> = session
        .attempts
        .iter()
        .filter(|attempt| {
            accepted_attempts.contains(attempt) && attempt.label.block == TrialBlock::Main
        })
        .map(|attempt| attempt.label)
        .collect();
    let losses = accepted_labels.iter().filter_map(|&label| {
        let defect = if folder_labels.contains(&label) {
            loss(&folder.join(label.to_string()))?
        } else {
            RecordingDefect::NoFolder
        };
        let is_last = accepted_labels.last() == Some(&label);
        Some(LostRecording {
            label,
            defect,
            is_last,
        })
    });
    Ok(losses.collect())
}

/// Returns the reason if no part of the recording in `folder` can be relied on.
fn loss(folder: &Path) -> Option<RecordingDefect> {
    let reader = match RecordingReader::open(folder) {
        Ok(reader) => reader,
        Err(error) => {
            let reason = error.to_string();
            return Some(RecordingDefect::Unreadable { reason });
        }
    };
    let end = reader.manifest().trial.as_ref().map(|trial| trial.end);
    match end {
        Some(Some(End::Interrupted)) => Some(RecordingDefect::AcceptedBrokenOff),
        Some(None) => Some(RecordingDefect::NoEnd),
        _ if reader.frames() == 0 => {
            let warning = Warning::Signals(WavWarning::Empty).to_string();
            Some(RecordingDefect::Warned { warning })
        }
        _ => None,
    }
}
