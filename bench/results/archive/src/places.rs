//! Places of recordings in an archive, which has the folders of the study.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use recording::MANIFEST_FILE;
use recording::disk;
use recording::study::EVENTS_FILE;
use study::exclusions::study_of;
use study::listing;

use crate::archive_error::ArchiveError;

/// Recording with its place in an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    /// Folder of the recording.
    pub(crate) source: PathBuf,
    /// Folder in the archive, relative to it.
    pub(crate) name: PathBuf,
}

/// Folder of a study, participant or session of which the files are part of an archive.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SharedFolder {
    /// The folder.
    pub(crate) source: PathBuf,
    /// Folder in the archive, relative to it.
    pub(crate) name: PathBuf,
}

/// Recordings and files of an archive.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Plan {
    /// Recordings, in the order of their names.
    pub(crate) recordings: Vec<Place>,
    /// Folders above them with files to copy.
    pub(crate) shared_folders: Vec<SharedFolder>,
    /// Study of the recordings, if they are of one.
    pub(crate) study: Option<PathBuf>,
}

/// Returns the plan of an archive of the recordings in `folders`, each once.
///
/// # Errors
/// A folder has no recording, the target lies in a study, two recordings have one place, or they are of two studies.
pub(crate) fn plan(folders: &[PathBuf], target: &Path) -> Result<Plan, ArchiveError> {
    let mut places: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    let mut shared_folders = BTreeMap::new();
    let mut plan = Plan::default();
    for folder in folders {
        let sources = listing::recordings(folder)?;
        if sources.is_empty() {
            return Err(ArchiveError::Nothing {
                path: folder.clone(),
            });
        }
        let study = study_of(folder);
        let guarded = study.clone().unwrap_or_else(|| folder.clone());
        if disk::is_within(target, &guarded) {
            return Err(ArchiveError::InsideStudy {
                target: target.to_owned(),
                study: guarded,
            });
        }
        match (&plan.study, study) {
            (Some(first), Some(second)) if *first != second => {
                return Err(ArchiveError::TwoStudies {
                    first: first.clone(),
                    second,
                });
            }
            (_, study) => plan.study = plan.study.or(study),
        }
        let base = base_of(folder);
        for source in sources {
            let path = canonical(&source);
            let name = path.strip_prefix(&base).unwrap_or(&path).to_owned();
            for above in name.ancestors().skip(1) {
                let above_source = base.join(above);
                // The folder of a single recording may have anything else.
                if above != Path::new("") || is_session_or_study(&base) {
                    shared_folders.insert(above.to_owned(), above_source);
                }
            }
            let first = places.insert(name.clone(), source.clone());
            if let Some(first) = first.filter(|first| canonical(first) != path) {
                return Err(ArchiveError::SameName {
                    first,
                    second: source,
                    name,
                });
            }
        }
    }
    let places = places.into_iter();
    plan.recordings = places
        .map(|(name, source)| Place { source, name })
        .collect();
    let shared_folders = shared_folders.into_iter();
    plan.shared_folders = shared_folders
        .map(|(name, source)| SharedFolder { source, name })
        .collect();
    Ok(plan)
}

fn canonical(folder: &Path) -> PathBuf {
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

/// Returns the folder to which names in the archive are relative: the study, or else the folder given, or that of a recording.
fn base_of(folder: &Path) -> PathBuf {
    if let Some(study) = study_of(folder) {
        return study;
    }
    let path = canonical(folder);
    match path.join(MANIFEST_FILE).exists() {
        true => path.parent().map_or_else(|| path.clone(), Path::to_owned),
        false => path,
    }
}

/// Returns whether the files of a folder belong to the recordings in it.
fn is_session_or_study(folder: &Path) -> bool {
    folder.join(EVENTS_FILE).exists() || study_of(folder).is_some()
}
