//! Reasons not to resume a session with a readable log.

use std::path::PathBuf;

use escaping::quoted;

/// Reason not to resume a session with a readable log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ResumeError {
    /// The log of the session does not state the trials that are left.
    #[error(
        "the log of {} cannot be trusted, so the trials still to be done are unknown: {because}; put back its events.jsonl from a copy, or \
         begin another session with --new-session; `friction-bench verify {}` says more",
        .session.display(), quoted(session)
    )]
    Distrusted {
        /// Folder of the session.
        session: PathBuf,
        /// Reason.
        because: String,
    },
    /// The session's copy of its protocol cannot be compared with the protocol of today.
    #[error(
        "{}, the session's copy of its protocol, {because}: put it back from a copy of the study, or begin another session with \
         --new-session",
        .copy.display()
    )]
    Copy {
        /// The copy.
        copy: PathBuf,
        /// Reason.
        because: String,
    },
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
