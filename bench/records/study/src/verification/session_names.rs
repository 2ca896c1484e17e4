//! Names in a session's folder and in its log.

use std::path::Path;

use recording::DiskError;
use recording::disk::entries;
use recording::study::TrialLabel;
use recording::study::event_log::Start;

/// Returns the recordings that have a folder in the session.
///
/// # Errors
/// The folder cannot be listed.
pub fn recordings(session: &Path) -> Result<Vec<TrialLabel>, DiskError> {
    let mut labels: Vec<TrialLabel> = entries(session)?
        .iter()
        .filter_map(|name| name.parse().ok())
        .collect();
    labels.sort_unstable();
    Ok(labels)
}

/// Returns participant and session of a start.
pub(super) fn session_words(start: &Start) -> String {
    format!("{}, session {}", start.participant, start.session)
}

/// Returns participant and session by the names of the folders, if these follow a study's scheme.
pub(super) fn folder_session(folder: &Path) -> Option<String> {
    let folder = folder.canonicalize().ok()?;
    let number: u32 = folder
        .file_name()?
        .to_str()?
        .strip_prefix("ses-")?
        .parse()
        .ok()?;
    let participant = folder.parent()?.file_name()?.to_str()?;
    Some(format!("{participant}, session {number}"))
}
