//! Sessions of a study by their logs: when each recording began and how each attempt was settled.

mod fold;
mod log_defect;
mod order;
mod session;
mod standing;

use std::path::{Path, PathBuf};

use protocols::Protocol;
use recording::study::EVENTS_FILE;
use recording::study::event_log::{self, Document, LogContent};

pub use fold::history;
pub use log_defect::LogDefect;
pub use session::{Attempt, CarrierChange, LoggedFit, LoggedSession, SessionEnd};
pub use standing::Standing;

/// Sessions that a list of recordings belongs to.
#[derive(Debug, Default)]
pub struct Sessions {
    /// Folder of each session with its history, or why its log cannot be read; in the order of the recordings.
    pub list: Vec<(PathBuf, Result<LoggedSession, String>)>,
}

impl Sessions {
    /// Reads the logs of the sessions that contain these recording folders. Recordings outside a session are skipped.
    pub fn from_recordings<'a>(recordings: impl IntoIterator<Item = &'a Path>) -> Self {
        let mut sessions = Self::default();
        for recording in recordings {
            let Some(folder) = folder_of(recording) else {
                continue;
            };
            if sessions.list.iter().any(|(path, _)| *path == folder) {
                continue;
            }
            let session = read(&folder);
            sessions.list.push((folder, session));
        }
        sessions
    }

    /// Returns the session that contains a recording; `None` without a readable log.
    #[must_use]
    pub fn session_of(&self, recording: &Path) -> Option<(&Path, &LoggedSession)> {
        let folder = folder_of(recording)?;
        let mut list = self.list.iter();
        let (folder, session) = list.find(|(path, _)| *path == folder)?;
        Some((folder, session.as_ref().ok()?))
    }

    /// Returns the attempt of a recording by the log of its session.
    #[must_use]
    pub fn attempt(&self, recording: &Path) -> Option<&Attempt> {
        let name = recording.canonicalize().ok()?;
        let label = name.file_name()?.to_string_lossy().parse().ok()?;
        let (_, session) = self.session_of(recording)?;
        session.attempt(label)
    }
}

/// Reads the log of the session in `folder`.
///
/// # Errors
/// The log cannot be read; returns the reason as text.
pub fn read(folder: &Path) -> Result<LoggedSession, String> {
    let content = event_log::read(&folder.join(EVENTS_FILE)).map_err(|error| error.to_string())?;
    Ok(history_in(folder, &content))
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

/// Returns the folder of a recording's session, if it has a log.
fn folder_of(recording: &Path) -> Option<PathBuf> {
    let folder = recording.canonicalize().ok()?.parent()?.to_owned();
    folder.join(EVENTS_FILE).exists().then_some(folder)
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
