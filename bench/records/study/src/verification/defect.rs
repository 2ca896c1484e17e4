//! Defects of recordings, sessions and studies.

use std::path::PathBuf;

use recording::study::TrialLabel;

/// Defect of a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingDefect {
    /// The log mentions the recording, but its folder does not exist.
    #[error("its folder is missing")]
    NoFolder,
    /// A file is missing.
    #[error("{file} is missing")]
    NoFile {
        /// The file.
        file: String,
    },
    /// The SHA-256 of a file differs from the one in the log.
    #[error("{file} has changed since it was recorded: its SHA-256 differs from the log's")]
    SumDiffers {
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
    /// The log does not begin with a start, or continues without one after a stop.
    #[error(
        "events.jsonl, document {document}: an event or a stop before any start; lines are missing or in another order"
    )]
    NoStart {
        /// The document, from 1.
        document: usize,
    },
    /// Event numbers are missing, duplicated or out of order.
    #[error(
        "events.jsonl: event {found} follows where event {expected} belongs: lines are missing or in another order"
    )]
    Number {
        /// Expected number.
        expected: u64,
        /// Number in the log.
        found: u64,
    },
    /// The audio clock goes back between two events.
    #[error(
        "events.jsonl, event {number}: its time {audio_s} s is before the last event's, {before_s} s"
    )]
    Time {
        /// Number of the event.
        number: u64,
        /// Time of the event, s.
        audio_s: f64,
        /// Time of the event before it, s.
        before_s: f64,
    },
    /// The stream of an event has no descriptor.
    #[error("events.jsonl, event {number}: stream `{stream}` has no descriptor before it")]
    Undescribed {
        /// Number of the event.
        number: u64,
        /// Stream of the event.
        stream: String,
    },
    /// The number of events in a stop differs from the number in the log.
    #[error("events.jsonl: {found} events before a stop that counts {expected}: lines are missing")]
    Count {
        /// Number in the stop.
        expected: u64,
        /// Number in the log.
        found: u64,
    },
    /// A stop calls the session complete although some of its trials were not settled.
    #[error(
        "events.jsonl calls the session complete, and {settled} of its {planned} trials were settled"
    )]
    NotAllSettled {
        /// Planned trials.
        planned: usize,
        /// Settled trials.
        settled: usize,
    },
    /// A trial was begun, settled or saved out of order.
    #[error("events.jsonl, event {number}: {trial} {fault}")]
    Order {
        /// Number of the event.
        number: u64,
        /// The trial.
        trial: TrialLabel,
        /// Description of the fault.
        fault: &'static str,
    },
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
    /// The session's copy of a file is not TOML.
    #[error("{file} cannot be read: {reason}")]
    BrokenCopy {
        /// The file.
        file: String,
        /// Error text of the parser.
        reason: String,
    },
    /// A folder contains a recording that is not a trial of this session.
    #[error("{name} is a recording, but not a trial of this session; it was put here later")]
    ForeignRecording {
        /// Name of the folder.
        name: String,
    },
}

impl SessionDefect {
    /// Returns whether the defect may hide trials: lines of the log are missing or out of order.
    #[must_use]
    pub fn hides_trials(&self) -> bool {
        matches!(
            self,
            Self::NoStart { .. } | Self::Number { .. } | Self::Count { .. } | Self::Order { .. }
        )
    }
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
    #[error("participants.tsv lists {participant}, but there is no folder of that name")]
    NoParticipant {
        /// The participant.
        participant: String,
    },
}
