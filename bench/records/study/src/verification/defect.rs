//! Defects of recordings, sessions and studies.

use std::path::PathBuf;

use crate::identity::Duplicate;
use crate::sessions::LogDefect;

/// Defect of a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingDefect {
    /// The log mentions the recording, but its folder does not exist.
    #[error("its folder is missing")]
    NoFolder,
    /// A file is missing.
    #[error("{file} is missing{reason}")]
    NoFile {
        /// The file.
        file: String,
        /// Reason and remedy as the end of the sentence, if known.
        reason: String,
    },
    /// The SHA-256 of a file differs from the one in the log.
    #[error("{file} has changed since it was recorded: its SHA-256 differs from the log's")]
    SumDiffers {
        /// The file.
        file: String,
    },
    /// The SHA-256 of a file differs from the one in the archive's description.
    #[error(
        "{file} has changed since it was archived: its SHA-256 differs from that in recording.toml; archive the recording again"
    )]
    ArchivedSumDiffers {
        /// The file.
        file: String,
    },
    /// The recording that was archived differs from the one in the log.
    #[error(
        "the archive was made of a {file} that had changed since it was recorded: its SHA-256 differs from the log's"
    )]
    OriginalDiffers {
        /// The file.
        file: String,
    },
    /// The SHA-256 of a file differs from the one in the log only by the line ends.
    #[error(
        "{file} is not as it was recorded: its line ends changed, as by git's core.autocrlf; no number changed, and `analyze` reads it"
    )]
    LineEndsDiffer {
        /// The file.
        file: String,
    },
    /// A file cannot be read, or violates the format.
    #[error("{reason}")]
    Unreadable {
        /// Error text of the reader.
        reason: String,
    },
    /// The recording can be read, but is incomplete or not as the recorder writes it.
    #[error("{warning}")]
    Warned {
        /// Text of the reader's warning.
        warning: String,
    },
    /// The description names another trial, session or participant than the folder.
    #[error("recording.toml is of {found}, and the folder of {expected}")]
    OtherTrial {
        /// Trial in the description.
        found: String,
        /// Trial by the names of the folders.
        expected: String,
    },
    /// The log calls the trial saved or settled, but its description has no `end`.
    #[error("recording.toml has no `end`, though the log says that the trial ended")]
    NoEnd,
    /// The log calls the trial interrupted, but its description calls it complete.
    #[error("recording.toml says that the trial is complete, and the log that it was broken off")]
    OtherEnd,
    /// The log calls the trial accepted, but its recording was interrupted.
    #[error(
        "the log says that the trial was accepted, and recording.toml that its recording was broken off"
    )]
    AcceptedBrokenOff,
    /// The log calls the trial accepted, but never its recording saved.
    #[error("the log says that the trial was accepted, and not that its recording was saved")]
    AcceptedUnsaved,
    /// The log marks a different number of intervals than the recording of an accepted trial has.
    #[error(
        "the log marks {marked} intervals of the accepted trial, and recording.toml has {recorded}"
    )]
    OtherIntervals {
        /// Number in the log.
        marked: usize,
        /// Number in the description.
        recorded: usize,
    },
    /// A sensor has no readings for part of an accepted trial.
    #[error(
        "{file} has no rows from {from_s:.3} to {to_s:.3} s, although the trial was accepted and recording.toml names its sensor"
    )]
    NoRowsOf {
        /// The file.
        file: &'static str,
        /// Start of the part of an exploration, s.
        from_s: f64,
        /// End of that part, s.
        to_s: f64,
    },
    /// Frames that the description calls lost have samples, or are not in the file at all.
    #[error(
        "recording.toml says that {frames} frames from {sample} on were lost, but signals.wav has samples there"
    )]
    GapWithSamples {
        /// First lost frame.
        sample: u64,
        /// Number of lost frames.
        frames: u64,
    },
    /// Frames without a value that no event explains.
    #[error("{frames} frames of signals.wav are lost, and no event of recording.toml says so")]
    UnexplainedLoss {
        /// Number of frames.
        frames: u64,
    },
    /// The log does not mention the recording.
    #[error("it is not in the log: it was put here later, or lines of the log are missing")]
    NotInLog,
}

/// Defect of a session, apart from its recordings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SessionDefect {
    /// There are recordings, but the log is missing.
    #[error("events.jsonl is missing")]
    NoLog,
    /// The log cannot be read.
    #[error("{reason}")]
    Unreadable {
        /// Error text of the reader.
        reason: String,
    },
    /// The events of the log are out of order.
    #[error(transparent)]
    Log(#[from] LogDefect),
    /// The log names another participant or session than its folder.
    #[error("events.jsonl is of {found}, and the folder of {expected}")]
    OtherSession {
        /// Participant and session of the log.
        found: String,
        /// Participant and session by the names of the folders.
        expected: String,
    },
    /// The session's copy of a file is missing.
    #[error("{file} is missing: the session's copy of it")]
    NoCopy {
        /// The file.
        file: String,
    },
    /// The session's copy of a file was edited.
    #[error(
        "{file} was changed after the session wrote it: the session's copy of it has another SHA-256 in the log"
    )]
    ChangedCopy {
        /// The file.
        file: String,
    },
    /// The session's copy of a file is not TOML.
    #[error("the session's copy of a file cannot be read: {reason}")]
    BrokenCopy {
        /// The file.
        file: String,
        /// Words for the fault, with the file.
        reason: String,
    },
    /// A folder contains a recording that is not a trial of this session.
    #[error(
        "{name} is a recording, but not a trial of this session; it was put here later{}",
        duplicate.as_ref().map(|duplicate| format!(": {duplicate}")).unwrap_or_default()
    )]
    ForeignRecording {
        /// Name of the folder.
        name: String,
        /// Trial of this session that it duplicates, if any.
        duplicate: Option<Duplicate>,
    },
    /// The folder is a copy of another session's.
    #[error(
        "{name} is {} of {original}, as a synchronisation program or a backup leaves it: move it out of the study",
        if *is_equal { "a copy" } else { "a changed copy" }
    )]
    CopiedSession {
        /// Name of the folder.
        name: String,
        /// Name of the session's folder.
        original: String,
        /// Whether both have the same log.
        is_equal: bool,
    },
}

/// Defect of a study, apart from its sessions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StudyDefect {
    /// A file of the study cannot be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error text of the reader.
        reason: String,
    },
    /// `exclusions.tsv` cannot be used, so no recordings are analysed.
    #[error("{reason}")]
    Exclusions {
        /// Error text.
        reason: String,
    },
    /// A participant of `participants.tsv` has no folder.
    #[error(
        "participants.tsv lists {participant}, but there is no folder of that name{}",
        nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
    )]
    NoParticipant {
        /// The participant.
        participant: String,
        /// Folder with the same number.
        nearest: Option<String>,
    },
}
