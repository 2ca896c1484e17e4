//! `participants.tsv`: a line for each participant, with the day of the first session.

use std::path::Path;

use protocols::ParticipantId;

use super::study_error::StudyError;
use crate::disk::{self, DiskError};
use crate::storage::Storage;

const HEADER: &str = "participant_id\tfirst_session_date\tprotocol\n";

/// Makes an empty table unless there is one.
pub(super) fn require_table(storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
    if disk::exists(storage, path)? {
        return Ok(());
    }
    disk::replace_file_on(storage, path, HEADER.as_bytes())
}

/// Returns the line of a participant.
pub(super) fn line(
    participant: &ParticipantId,
    date: &str,
    protocol: &str,
) -> Result<String, StudyError> {
    for (field, value) in [("first_session_date", date), ("protocol", protocol)] {
        if value.contains(['\t', '\n', '\r']) {
            return Err(StudyError::Tsv {
                field,
                value: value.to_owned(),
            });
        }
    }
    Ok(format!("{}\t{date}\t{protocol}\n", participant.as_str()))
}

/// Adds the participant's line unless the table has one; the table is replaced as a whole, so that no line is ever
/// torn.
pub(super) fn register(
    storage: &dyn Storage,
    path: &Path,
    participant: &ParticipantId,
    line: &str,
) -> Result<(), DiskError> {
    let mut table = disk::read_on(storage, path, files::TEXT_LIMIT_BYTES)?;
    let known = table.split(|&byte| byte == b'\n').any(|line| {
        let name = line.split(|&byte| byte == b'\t').next();
        name == Some(participant.as_str().as_bytes())
    });
    if known {
        // A copy that was not synced before is now.
        return disk::sync_parent(storage, path);
    }
    if !table.ends_with(b"\n") {
        // Torn by an earlier version, which appended.
        table.push(b'\n');
    }
    table.extend_from_slice(line.as_bytes());
    disk::replace_file_on(storage, path, &table)
}
