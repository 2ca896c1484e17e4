//! Verification of a study's sessions and of its other files.

use std::path::{Path, PathBuf};

use crate::verification::defect::StudyDefect;
use crate::verification::findings::StudyFindings;
use recording::disk::entries;
use recording::study::{
    DESCRIPTION_FILE, EVENTS_FILE, ID_COLUMN, PARTICIPANTS_FILE, TrialLabel, parse_description,
};
use recording::{DiskError, MANIFEST_FILE, rights};
use text_tables::TabTable;

/// Levels of folders below a study: participants, sessions.
const DEPTH: usize = 2;

/// Why a folder cannot be verified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A folder cannot be listed.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The path is not a folder.
    #[error(
        "{} is not a folder{}",
        path.display(),
        nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
    )]
    NoFolder {
        /// Given path.
        path: PathBuf,
        /// Sibling folder with the most similar name.
        nearest: Option<String>,
    },
    /// The folder is a recording.
    #[error("{} is a recording; only its session's log has sums: name its session or study", path.display())]
    Recording {
        /// The folder.
        path: PathBuf,
    },
    /// The folder contains no session.
    #[error("{} is not a study, participant or session: it contains no {EVENTS_FILE}", path.display())]
    NoSession {
        /// The folder.
        path: PathBuf,
    },
}

/// Returns the sessions of the study, participant or session at `path`, in order.
///
/// # Errors
/// [`VerifyError`] names the folder, and the most similar one.
pub fn sessions(path: &Path) -> Result<Vec<PathBuf>, VerifyError> {
    if !path.is_dir() {
        return Err(VerifyError::NoFolder {
            path: path.to_owned(),
            nearest: nearest(path),
        });
    }
    if path.join(MANIFEST_FILE).exists() {
        return Err(VerifyError::Recording {
            path: path.to_owned(),
        });
    }
    let mut sessions = Vec::new();
    descend(path, DEPTH, &mut sessions)?;
    if sessions.is_empty() && !path.join(DESCRIPTION_FILE).exists() {
        return Err(VerifyError::NoSession {
            path: path.to_owned(),
        });
    }
    Ok(sessions)
}

fn descend(folder: &Path, depth: usize, sessions: &mut Vec<PathBuf>) -> Result<(), DiskError> {
    let names = entries(folder)?;
    let is_session = names.iter().any(|name| {
        name == EVENTS_FILE || name.parse::<TrialLabel>().is_ok() && folder.join(name).is_dir()
    });
    if is_session {
        sessions.push(folder.to_owned());
    } else if depth > 0 {
        for name in names {
            let path = folder.join(name);
            if path.is_dir() {
                descend(&path, depth - 1, sessions)?;
            }
        }
    }
    Ok(())
}

/// Returns the sibling of `path` with the most similar name.
fn nearest(path: &Path) -> Option<String> {
    let parent = path.parent()?;
    let folder = if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    };
    let mut folders = entries(folder).ok()?;
    folders.retain(|name| folder.join(name).is_dir());
    let name = strict_toml::nearest(path.file_name()?.to_str()?, &folders)?;
    Some(parent.join(name).display().to_string())
}

/// Returns the participants in the table at `path`.
///
/// # Errors
/// The words for the fault of the table.
fn participants(path: &Path) -> Result<Vec<String>, String> {
    let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES);
    let text = text.map_err(|error| bounded_files::cause(&error))?;
    let table = TabTable::parse(text, ID_COLUMN).map_err(|fault| fault.to_string())?;
    if let Some(fault) = table.uneven_row() {
        return Err(fault.to_string());
    }
    let id_column = table.column(ID_COLUMN).unwrap_or_default();
    let ids = table
        .rows()
        .iter()
        .filter_map(|row| row.cells.get(id_column));
    Ok(ids.filter(|id| !id.is_empty()).cloned().collect())
}

/// Verifies the files of the study outside its sessions, if `folder` is a whole study.
///
/// # Errors
/// The folder cannot be listed.
pub fn verify_study_files(folder: &Path, findings: &mut StudyFindings) -> Result<(), DiskError> {
    let description = folder.join(DESCRIPTION_FILE);
    if !description.exists() {
        return Ok(());
    }
    findings
        .notes
        .extend(rights::other_readers(folder, &description));
    let unreadable_defect =
        |path: PathBuf, reason: String| StudyDefect::Unreadable { path, reason };
    let description_result = bounded_files::read(&description, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| bounded_files::cause(&error))
        .and_then(|text| parse_description(&text));
    if let Err(reason) = description_result {
        findings
            .defects
            .push(unreadable_defect(description, reason));
    }
    let table = folder.join(PARTICIPANTS_FILE);
    let participants = match participants(&table) {
        Ok(participants) => participants,
        Err(reason) => {
            findings.defects.push(unreadable_defect(table, reason));
            return Ok(());
        }
    };
    for participant in &participants {
        if !folder.join(participant).is_dir() {
            let participant = participant.clone();
            findings
                .defects
                .push(StudyDefect::NoParticipant { participant });
        }
    }
    for name in entries(folder)? {
        if folder.join(&name).is_dir() && !participants.contains(&name) {
            let count = recording_count(&folder.join(&name), DEPTH);
            let contents = match count {
                0 => String::new(),
                _ => format!("; `analyze` reads the {count} recordings in it, except copies"),
            };
            let name = escaping::escaped_line(&name);
            let note = format!("{name} is not in {PARTICIPANTS_FILE}{contents}");
            findings.notes.push(note);
        }
    }
    Ok(())
}

/// Returns the number of recordings down to `depth` levels below a folder.
fn recording_count(folder: &Path, depth: usize) -> usize {
    let names = entries(folder).unwrap_or_default();
    let folders = names.iter().map(|name| folder.join(name));
    let count = |path: PathBuf| match depth {
        _ if path.join(MANIFEST_FILE).exists() => 1,
        0 => 0,
        _ => recording_count(&path, depth - 1),
    };
    folders.map(count).sum()
}
