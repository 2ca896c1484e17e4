//! Verification of a study's sessions and of its other files.

use std::fs;
use std::path::{Path, PathBuf};

use crate::defect::StudyDefect;
use crate::findings::StudyFindings;
use recording::disk::entries;
use recording::study::{DESCRIPTION_FILE, Description, EVENTS_FILE, PARTICIPANTS_FILE, TrialLabel};
use recording::{DiskError, MANIFEST_FILE};

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
    #[error("{} is no study, participant or session: there is no {EVENTS_FILE} in it", path.display())]
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
    let mut found = Vec::new();
    descend(path, DEPTH, &mut found)?;
    if found.is_empty() && !path.join(DESCRIPTION_FILE).exists() {
        return Err(VerifyError::NoSession {
            path: path.to_owned(),
        });
    }
    Ok(found)
}

fn descend(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) -> Result<(), DiskError> {
    let names = entries(folder)?;
    let is_session = names.iter().any(|name| {
        name == EVENTS_FILE || name.parse::<TrialLabel>().is_ok() && folder.join(name).is_dir()
    });
    if is_session {
        found.push(folder.to_owned());
    } else if depth > 0 {
        for name in names {
            let path = folder.join(name);
            if path.is_dir() {
                descend(&path, depth - 1, found)?;
            }
        }
    }
    Ok(())
}

/// Returns the sibling of `path` with the most similar name.
fn nearest(path: &Path) -> Option<String> {
    let beside = path.parent()?;
    let here = if beside.as_os_str().is_empty() {
        Path::new(".")
    } else {
        beside
    };
    let mut folders = entries(here).ok()?;
    folders.retain(|name| here.join(name).is_dir());
    let name = strict::nearest(path.file_name()?.to_str()?, &folders)?;
    Some(beside.join(name).display().to_string())
}

/// Verifies the files of the study outside its sessions, if `folder` is a whole study.
///
/// # Errors
/// The folder cannot be listed.
pub fn beside_sessions(folder: &Path, found: &mut StudyFindings) -> Result<(), DiskError> {
    let description = folder.join(DESCRIPTION_FILE);
    if !description.exists() {
        return Ok(());
    }
    let unreadable = |path: PathBuf, reason: String| StudyDefect::Unreadable { path, reason };
    let parsed = fs::read(&description)
        .map_err(|error| error.to_string())
        .and_then(|text| {
            serde_json::from_slice::<Description>(&text).map_err(|error| error.to_string())
        });
    if let Err(reason) = parsed {
        found.defects.push(unreadable(description, reason));
    }
    let table = folder.join(PARTICIPANTS_FILE);
    let listed = match fs::read_to_string(&table) {
        Ok(text) => text,
        Err(error) => {
            found.defects.push(unreadable(table, error.to_string()));
            return Ok(());
        }
    };
    let listed: Vec<&str> = listed
        .lines()
        .skip(1)
        .filter_map(|line| line.split('\t').next())
        .filter(|name| !name.is_empty())
        .collect();
    for participant in &listed {
        if !folder.join(participant).is_dir() {
            let participant = (*participant).to_owned();
            found
                .defects
                .push(StudyDefect::NoParticipant { participant });
        }
    }
    for name in entries(folder)? {
        if folder.join(&name).is_dir() && !listed.contains(&name.as_str()) {
            found
                .notes
                .push(format!("{name} is not in {PARTICIPANTS_FILE}"));
        }
    }
    Ok(())
}
