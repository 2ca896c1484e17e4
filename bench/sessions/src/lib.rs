//! What the logs of a study's sessions tell of its recordings: when each began, and how each attempt was settled.

mod session;

use std::path::{Path, PathBuf};

use recording::study::{EVENTS_FILE, event_log};

pub use session::{Attempt, Session, SessionEnd};

/// Sessions that recordings are of.
#[derive(Debug, Default)]
pub struct Sessions {
    /// Folder of each and what its log tells, or why it cannot be read; in the order of the recordings.
    pub list: Vec<(PathBuf, Result<Session, String>)>,
}

impl Sessions {
    /// Reads the logs of the sessions that lie around these recording folders. Recordings made elsewhere have none.
    pub fn of<'a>(recordings: impl IntoIterator<Item = &'a Path>) -> Self {
        let mut sessions = Self::default();
        for recording in recordings {
            let Some(folder) = folder_of(recording) else {
                continue;
            };
            if sessions.list.iter().any(|(known, _)| *known == folder) {
                continue;
            }
            let read = event_log::read(&folder.join(EVENTS_FILE));
            let session = read.map(|content| Session::of(&content));
            sessions
                .list
                .push((folder, session.map_err(|error| error.to_string())));
        }
        sessions
    }

    /// Returns the session that a recording is of; `None` without a log that can be read.
    #[must_use]
    pub fn around(&self, recording: &Path) -> Option<(&Path, &Session)> {
        let folder = folder_of(recording)?;
        let mut list = self.list.iter();
        let (folder, session) = list.find(|(known, _)| *known == folder)?;
        Some((folder, session.as_ref().ok()?))
    }

    /// Returns what the log of its session tells of a recording.
    #[must_use]
    pub fn attempt(&self, recording: &Path) -> Option<&Attempt> {
        let name = recording.canonicalize().ok()?;
        let label = name.file_name()?.to_string_lossy().parse().ok()?;
        let (_, session) = self.around(recording)?;
        let mut attempts = session.attempts.iter();
        attempts.find(|attempt| attempt.label == label)
    }
}

/// Returns the folder of a recording's session, if it has a log.
fn folder_of(recording: &Path) -> Option<PathBuf> {
    let folder = recording.canonicalize().ok()?.parent()?.to_owned();
    folder.join(EVENTS_FILE).exists().then_some(folder)
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
