//! Finds recordings: recording folders themselves, or all trials of a study, a participant or a session.

use std::collections::BTreeMap;
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

use recording::manifest::End;
use recording::study::{TrialBlock, TrialLabel};
use recording::{MANIFEST_FILE, reader};

/// Levels of folders below a study: participants, sessions, trials.
const DEPTH: usize = 3;

/// Why a folder names no recordings.
#[derive(Debug, thiserror::Error)]
pub enum FindError {
    /// The folder cannot be listed.
    #[error("cannot list {}: {reason}", path.display())]
    List {
        /// The folder.
        path: PathBuf,
        /// The reason.
        reason: io::Error,
    },
    /// The folder is neither a recording nor holds any.
    #[error(
        "{} is no recording (it has no {MANIFEST_FILE}), and no study with completed trials{}",
        path.display(),
        if *.practice { "" } else { "; practice trials are left out unless --practice is given" }
    )]
    None {
        /// The folder.
        path: PathBuf,
        /// Whether practice trials were looked for.
        practice: bool,
    },
}

/// Returns the recording folders that `named` stands for, in order. A folder with a `recording.toml` is a recording. A
/// study stands for all its completed trials; among several attempts at a trial, for the last completed one, because
/// the others were redone. A folder that is named twice counts once.
///
/// # Errors
/// A folder cannot be listed, or holds no recording.
pub fn recordings(named: &[PathBuf], practice: bool) -> Result<Vec<PathBuf>, FindError> {
    let mut found = Vec::new();
    for path in named {
        if path.join(MANIFEST_FILE).exists() {
            found.push(path.clone());
            continue;
        }
        let before = found.len();
        descend(path, DEPTH, practice, &mut found)?;
        if found.len() == before {
            return Err(FindError::None {
                path: path.clone(),
                practice,
            });
        }
    }
    let mut seen = HashSet::new();
    found.retain(|path| seen.insert(path.canonicalize().unwrap_or_else(|_| path.clone())));
    Ok(found)
}

fn descend(
    folder: &Path,
    depth: usize,
    practice: bool,
    found: &mut Vec<PathBuf>,
) -> Result<(), FindError> {
    let mut folders = list(folder)?;
    folders.sort_unstable();
    let mut trials: BTreeMap<(TrialBlock, u32), (TrialLabel, PathBuf)> = BTreeMap::new();
    for path in folders {
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        let label = name
            .as_deref()
            .and_then(|name| name.parse::<TrialLabel>().ok());
        match label {
            Some(label) if (label.block == TrialBlock::Main || practice) && may_count(&path) => {
                let latest = trials
                    .entry((label.block, label.number))
                    .or_insert_with(|| (label, path.clone()));
                if label.attempt > latest.0.attempt {
                    *latest = (label, path);
                }
            }
            Some(_) => {}
            None if path.join(MANIFEST_FILE).exists() => found.push(path),
            None if depth > 1 => descend(&path, depth - 1, practice, found)?,
            None => {}
        }
    }
    found.extend(trials.into_values().map(|(_, path)| path));
    Ok(())
}

/// Returns whether the trial in `folder` completed. An unreadable one counts, so that it is reported and not passed
/// over.
fn may_count(folder: &Path) -> bool {
    reader::read_manifest(folder).map_or(true, |manifest| {
        manifest
            .trial
            .is_none_or(|trial| trial.end == Some(End::Completed))
    })
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, FindError> {
    let error = |reason| FindError::List {
        path: folder.to_owned(),
        reason,
    };
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(error)? {
        let path = entry.map_err(error)?.path();
        if path.is_dir() {
            folders.push(path);
        }
    }
    Ok(folders)
}
