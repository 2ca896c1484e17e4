//! Places of imported recordings in a study: their state before an import, their replacement, their removal.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use import_map::NamedFile;
use protocols::TrialLabel;
use recording::manifest::{Imported, ImportedMap, ImportedSource};
use recording::reader::read_manifest;
use recording::study::session_name;
use recording::{
    ENVELOPES_FILE, FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE, STIMULUS_FILE,
};

use crate::figure::FIGURE_FILE;
use crate::refusal::ImportRefusal;

/// Files that an import writes into a recording's folder.
const FILES: [&str; 7] = [
    FIGURE_FILE,
    SIGNALS_FILE,
    ENVELOPES_FILE,
    FORCE_FILE,
    POSITION_FILE,
    STIMULUS_FILE,
    MANIFEST_FILE,
];
/// Beginning of the name of a folder in which a recording is written before it is complete.
const UNFINISHED: &str = ".importing-";

/// Folder of a recording in a study.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    session: PathBuf,
    name: String,
}

/// State of a place before an import.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// No recording is there.
    Free,
    /// The recording of the same bytes and the same map is there.
    Same,
    /// A recording of an earlier state of the map or of the files is there.
    Earlier,
}

impl Place {
    /// Returns the place of a file's recording.
    pub fn new(study: &Path, file: &NamedFile) -> Self {
        Self {
            session: study
                .join(file.participant.as_str())
                .join(session_name(file.session)),
            name: TrialLabel::of_block(false, file.trial, file.attempt).to_string(),
        }
    }

    /// Returns the recording's name within the study, such as `sub-01/ses-01/trial-001_attempt-1`.
    pub fn name(file: &NamedFile) -> String {
        let label = TrialLabel::of_block(false, file.trial, file.attempt);
        format!(
            "{}/{}/{label}",
            file.participant,
            session_name(file.session)
        )
    }

    /// Returns the folder.
    pub fn folder(&self) -> PathBuf {
        self.session.join(&self.name)
    }

    /// Returns the state of the place.
    pub fn state(
        &self,
        map: &ImportedMap,
        sources: &[ImportedSource],
        main: &str,
    ) -> Result<State, ImportRefusal> {
        let folder = self.folder();
        if fs::symlink_metadata(&folder).is_err() {
            return Ok(State::Free);
        }
        let Some(there) = imported(&folder) else {
            return Err(ImportRefusal::Occupied {
                recording: folder.display().to_string(),
            });
        };
        let has = |all: &[ImportedSource], source: &ImportedSource| {
            let mut all = all.iter();
            all.any(|known| known.file == source.file && known.sha256 == source.sha256)
        };
        // A part that was added later is a source that is not recorded.
        let has_same = there.sources.iter().all(|source| has(sources, source))
            && sources.iter().all(|source| has(&there.sources, source));
        if there.map.sha256 == map.sha256 && has_same {
            return Ok(State::Same);
        }
        // Another session in another folder may have the same names.
        let is_known = there.map.sha256 == map.sha256
            || sources.iter().any(|source| has(&there.sources, source));
        let is_of_map = is_known
            && there.map.file == map.file
            && there.sources.iter().any(|source| source.file == main);
        match is_of_map {
            true => Ok(State::Earlier),
            false => Err(ImportRefusal::Occupied {
                recording: folder.display().to_string(),
            }),
        }
    }

    /// Creates the folder in which the recording is written.
    pub fn begin(&self) -> Result<PathBuf, ImportRefusal> {
        let folder = self.session.join(format!("{UNFINISHED}{}", self.name));
        // Left by a program that was killed.
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).map_err(|error| ImportRefusal::system(&folder, &error))?;
        Ok(folder)
    }

    /// Puts the complete recording into its place.
    pub fn complete(&self, unfinished: &Path) -> Result<(), ImportRefusal> {
        let folder = self.folder();
        let move_in = || -> std::io::Result<()> {
            if folder.exists() {
                remove_files(&folder)?;
                // Files that people added move along.
                for entry in fs::read_dir(&folder)? {
                    let entry = entry?;
                    fs::rename(entry.path(), unfinished.join(entry.file_name()))?;
                }
                fs::remove_dir(&folder)?;
            }
            fs::rename(unfinished, &folder)
        };
        move_in().map_err(|error| ImportRefusal::system(&folder, &error))?;
        recording::disk::sync_folder(&self.session).map_err(|error| ImportRefusal::System {
            path: self.session.display().to_string(),
            cause: error.to_string(),
        })
    }

    /// Removes an incomplete recording, and the folders above it that are empty.
    pub fn abandon(&self, unfinished: &Path) {
        let _ = fs::remove_dir_all(unfinished);
        remove_empty(&self.session);
    }
}

/// Returns the import of the recording in a folder; `None` if it was not imported.
pub(crate) fn imported(folder: &Path) -> Option<Imported> {
    read_manifest(folder).ok()?.origin?.imported
}

/// Removes the files of an imported recording; returns the names of the others that remain.
pub(crate) fn remove(folder: &Path) -> std::io::Result<Vec<String>> {
    remove_files(folder)?;
    let mut others = Vec::new();
    for entry in fs::read_dir(folder)? {
        others.push(entry?.file_name().to_string_lossy().into_owned());
    }
    if others.is_empty() {
        fs::remove_dir(folder)?;
        if let Some(session) = folder.parent() {
            remove_empty(session);
        }
    }
    Ok(others)
}

fn remove_files(folder: &Path) -> std::io::Result<()> {
    for name in FILES {
        match fs::remove_file(folder.join(name)) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}

/// Removes a session's folder and its participant's, as far as they are empty.
fn remove_empty(session: &Path) {
    if fs::remove_dir(session).is_ok()
        && let Some(participant) = session.parent()
    {
        let _ = fs::remove_dir(participant);
    }
}
