//! A guessed map, written to a file.

use std::io::Write;
use std::path::{Component, Path, PathBuf};

use escaping::escaped_line;
use source_files::{SourceError, SourceFile};

use crate::draft::{NoStreams, draft};
use crate::file_pattern::families;
use crate::purpose::Family;
use crate::survey::survey;

/// A map that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Guess {
    /// Number of lines marked `# CHECK`.
    pub checks: usize,
    /// Files that could not be looked at, each with the reason.
    pub unread: Vec<String>,
}

/// Reasons why no map is written.
#[derive(Debug, thiserror::Error)]
pub enum GuessError {
    /// The file of the map is there.
    #[error("{} exists already: name another file, or delete it", .0.display())]
    Exists(PathBuf),
    /// A recording is not in the map's folder.
    #[error(
        "{} is not in the folder of the map, {}: a map names files relative to its folder; write it into a folder above them",
        file.display(),
        folder.display()
    )]
    Outside {
        /// The recording.
        file: PathBuf,
        /// Folder of the map.
        folder: PathBuf,
    },
    /// No file can be looked at; this is the last one's reason.
    #[error(transparent)]
    Unread(Box<SourceError>),
    /// No array looks like a stream.
    #[error(transparent)]
    NoStreams(#[from] NoStreams),
    /// The map cannot be written, or a folder not be read.
    #[error("{}: {cause}", path.display())]
    System {
        /// The file or folder.
        path: PathBuf,
        /// Reason and remedy.
        cause: String,
    },
}

/// Looks at one file of each family of names, and writes a map for all of them to `to`. `progress` is called with a
/// line about the work under way, and with an empty one at its end.
///
/// # Errors
/// [`GuessError`]; then nothing is written.
pub fn guess(
    files: &[PathBuf],
    to: &Path,
    progress: &mut dyn FnMut(&str),
) -> Result<Guess, GuessError> {
    if to.exists() {
        return Err(GuessError::Exists(to.to_owned()));
    }
    let folder = match to.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut paths = Vec::new();
    for file in files {
        paths.push((relative(file, &folder)?, file.clone()));
    }
    let names: Vec<String> = paths.iter().map(|(name, _)| name.clone()).collect();
    let mut looked = Vec::new();
    let mut unread = Vec::new();
    let full = |name: &str| {
        let found = paths.iter().find(|(own, _)| own == name);
        found.map_or_else(|| folder.join(name), |(_, path)| path.clone())
    };
    let mut have_same_columns = |a: &str, b: &str| {
        // A file that cannot be read is named when it is looked at.
        match (columns(&full(a)), columns(&full(b))) {
            (Some(a), Some(b)) => a == b,
            _ => true,
        }
    };
    for family in families(&names, &mut have_same_columns) {
        let path = full(&family.names[0]);
        let shown = path.display().to_string();
        let found = survey(&path, &mut |done, count| {
            progress(&format!(
                "{}: array {} of {count}",
                escaped_line(&shown),
                done + 1
            ));
        });
        match found {
            Ok(portrait) => looked.push(Family {
                files: family,
                portrait,
            }),
            Err(error) => unread.push(error),
        }
    }
    progress("");
    if looked.is_empty()
        && let Some(error) = unread.pop()
    {
        return Err(GuessError::Unread(error));
    }
    let map = draft(looked)?;
    let system = |error: &std::io::Error| GuessError::System {
        path: to.to_owned(),
        cause: bounded_files::cause(error),
    };
    let mut file = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(to)
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => GuessError::Exists(to.to_owned()),
            _ => system(&error),
        })?;
    file.write_all(map.text().as_bytes())
        .map_err(|error| system(&error))?;
    Ok(Guess {
        checks: map.checks(),
        unread: unread.iter().map(ToString::to_string).collect(),
    })
}

/// Returns the names and units of a file's arrays, and the number of columns of each; `None` for a file that cannot be
/// read.
fn columns(path: &Path) -> Option<Vec<(String, Option<String>, u64)>> {
    let file = SourceFile::open(path).ok()?;
    let columns = file.arrays().iter().map(|info| {
        let longest = info.shape.iter().copied().max().unwrap_or(1).max(1);
        (info.name.clone(), info.unit.clone(), info.count() / longest)
    });
    Some(columns.collect())
}

/// Returns the name of a file relative to a folder, with `/` between its parts.
fn relative(file: &Path, folder: &Path) -> Result<String, GuessError> {
    let absolute = |path: &Path| {
        path.canonicalize().map_err(|error| GuessError::System {
            path: path.to_owned(),
            cause: bounded_files::cause(&error),
        })
    };
    let outside = || GuessError::Outside {
        file: file.to_owned(),
        folder: folder.to_owned(),
    };
    let (file_path, folder_path) = (absolute(file)?, absolute(folder)?);
    let inner = file_path
        .strip_prefix(&folder_path)
        .map_err(|_| outside())?;
    let parts: Vec<String> = inner
        .components()
        .filter_map(|part| match part {
            Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
            _ => None,
        })
        .collect();
    Ok(parts.join("/"))
}
