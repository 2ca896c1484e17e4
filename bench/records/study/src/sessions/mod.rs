//! Sessions of a study by their logs: when each recording began and how each attempt was settled.

mod fold;
mod foreign_log;
mod log_defect;
mod order;
mod session;
mod standing;

use std::collections::{BTreeMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};

use protocols::Protocol;
use recording::study::EVENTS_FILE;
use recording::study::event_log::{self, Document, LogContent};
use serde::{Deserialize, Serialize};

pub use fold::history;
pub use log_defect::LogDefect;
pub use session::{Attempt, CarrierChange, LoggedFit, LoggedSession, SessionEnd};
pub use standing::Standing;

/// Copy of the calibration in a session's folder.
pub const CALIBRATION_FILE: &str = "calibration.toml";

/// Sessions that a list of recordings belongs to.
#[derive(Debug, Default)]
pub struct Sessions {
    /// Folder of each session with its history, or why its log cannot be read; in the order of the recordings.
    pub list: Vec<(PathBuf, Result<LoggedSession, String>)>,
    /// Text of the copy of the calibration in the folder of a session, or the reason why it cannot be read.
    pub calibrations: BTreeMap<PathBuf, Result<String, String>>,
    /// Canonical path of each recording of a session, by its path as given.
    places: BTreeMap<PathBuf, PathBuf>,
}

impl Sessions {
    /// Reads the logs of the sessions that contain these recording folders. Recordings outside a session are skipped.
    pub fn from_recordings<'a>(recordings: impl IntoIterator<Item = &'a Path>) -> Self {
        let mut sessions = Self::default();
        let mut known_folders = HashSet::new();
        for recording in recordings {
            let Some(place) = place_of(recording) else {
                continue;
            };
            let folder = place.parent().unwrap_or(&place).to_owned();
            sessions.places.insert(recording.to_owned(), place);
            if known_folders.insert(folder.clone()) {
                sessions.push(RecordedSession::read(folder));
            }
        }
        sessions
    }

    /// Makes the list of these sessions and of the canonical paths of their recordings, by the paths as given.
    #[must_use]
    pub fn new(
        recorded: impl IntoIterator<Item = RecordedSession>,
        places: BTreeMap<PathBuf, PathBuf>,
    ) -> Self {
        let mut sessions = Self {
            places,
            ..Self::default()
        };
        recorded
            .into_iter()
            .for_each(|session| sessions.push(session));
        sessions
    }

    fn push(&mut self, session: RecordedSession) {
        let RecordedSession {
            folder,
            log,
            calibration,
        } = session;
        let calibration = calibration.map(|text| (folder.clone(), text));
        self.calibrations.extend(calibration);
        self.list.push((folder, log));
    }

    /// Returns the folder of the session that contains a recording, by the recording's path as given.
    #[must_use]
    pub fn folder_of(&self, recording: &Path) -> Option<&Path> {
        self.places.get(recording)?.parent()
    }

    /// Returns the session that contains a recording; `None` without a readable log.
    #[must_use]
    pub fn session_of(&self, recording: &Path) -> Option<(&Path, &LoggedSession)> {
        let folder = self.folder_of(recording)?;
        let mut list = self.list.iter();
        let (folder, session) = list.find(|(path, _)| path == folder)?;
        Some((folder, session.as_ref().ok()?))
    }

    /// Returns the attempt of a recording by the log of its session.
    #[must_use]
    pub fn attempt(&self, recording: &Path) -> Option<&Attempt> {
        let place = self.places.get(recording)?;
        let label = place.file_name()?.to_string_lossy().parse().ok()?;
        let (_, session) = self.session_of(recording)?;
        session.attempt(label)
    }
}

/// Reads the log of the session in `folder`.
///
/// # Errors
/// The log cannot be read, or is that of another session than the recordings; returns the reason as text.
pub fn read(folder: &Path) -> Result<LoggedSession, String> {
    let content = event_log::read(&folder.join(EVENTS_FILE)).map_err(|error| error.to_string())?;
    let session = history_in(folder, &content);
    match foreign_log::contradiction(folder, &session) {
        None => Ok(session),
        Some(reason) => Err(reason),
    }
}

/// Returns the history of the session in `folder` by its log `content`.
#[must_use]
pub fn history_in(folder: &Path, content: &LogContent) -> LoggedSession {
    history(content, practice(folder, content))
}

/// Returns the number of practice trials of the session in `folder`, by its copy of the protocol, or else by its log.
fn practice(folder: &Path, content: &LogContent) -> u32 {
    let start = content
        .documents
        .iter()
        .find_map(|document| match document {
            Document::Start(start) => Some(start),
            _ => None,
        });
    let copy_practice = || {
        let file = format!("{}.toml", start?.protocol);
        let text =
            bounded_files::read_text(&folder.join(&file), bounded_files::TEXT_LIMIT_BYTES).ok()?;
        // A later version may have other rules; the log serves as well.
        Some(Protocol::parse(&text, &file).ok()?.trials.practice)
    };
    copy_practice().unwrap_or_else(|| fold::logged_practice(content))
}

/// Returns the canonical path of a recording in a session, if the session has a log.
fn place_of(recording: &Path) -> Option<PathBuf> {
    let place = recording.canonicalize().ok()?;
    place.parent()?.join(EVENTS_FILE).exists().then_some(place)
}

/// A session by the files in its folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedSession {
    /// Folder.
    pub folder: PathBuf,
    /// History, or the reason why the log cannot be read.
    pub log: Result<LoggedSession, String>,
    /// Text of the copy of the calibration, or the reason why it cannot be read; `None` without one.
    pub calibration: Option<Result<String, String>>,
}

impl RecordedSession {
    /// Reads the session in `folder`.
    #[must_use]
    pub fn read(folder: PathBuf) -> Self {
        Self {
            log: read(&folder),
            calibration: calibration(&folder),
            folder,
        }
    }
}

fn calibration(folder: &Path) -> Option<Result<String, String>> {
    let path = folder.join(CALIBRATION_FILE);
    match bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES) {
        Ok(text) => Some(Ok(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => {
            let (path, cause) = (path.display(), bounded_files::cause(&error));
            Some(Err(format!("cannot read {path}: {cause}")))
        }
    }
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
