//! Reasons not to resume a session with a readable log.

use std::path::PathBuf;

/// Reason not to resume a session with a readable log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ResumeError {
    /// The protocol was edited since the last part.
    #[error(
        "{} was begun with another protocol {protocol}: {edits}; put it back as it was ({}), begin another session with \
         --new-session, or go on with the edited one by --accept-edited-protocol",
        .session.display(), .copy.display()
    )]
    EditedProtocol {
        /// Folder of the session.
        session: PathBuf,
        /// Name of the protocol.
        protocol: String,
        /// Keys that differ, with both values.
        edits: String,
        /// The session's copy of the original protocol.
        copy: PathBuf,
    },
    /// Recordings of accepted trials other than the last are lost.
    #[error(
        "{}: {lost}; if they were moved, put them back; if they are lost, go on and repeat their trials by --repeat-lost, or \
         begin another session with --new-session; `friction-bench verify {quoted}` says more",
        .session.display()
    )]
    LostRecordings {
        /// Folder of the session.
        session: PathBuf,
        /// Lost recordings, each with its defect.
        lost: String,
        /// The folder, quoted for a shell.
        quoted: String,
    },
}
