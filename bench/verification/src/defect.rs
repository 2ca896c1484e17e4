//! What can be wrong with a study that was recorded.

use std::path::PathBuf;

use recording::study::TrialLabel;

/// What is wrong with a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingDefect {
    /// The log speaks of the recording, and there is no folder.
    #[error("its folder is missing")]
    NoFolder,
    /// A file is missing.
    #[error("{file} is missing")]
    NoFile {
        /// The file.
        file: String,
    },
    /// A file has another SHA-256 than the log says.
    #[error("{file} is not as it was recorded: its SHA-256 is another than the log's")]
    SumDiffers {
        /// The file.
        file: String,
    },
    /// A file cannot be read, or breaks a rule of the format.
    #[error("{reason}")]
    Unreadable {
        /// Error text of the reader.
        reason: String,
    },
    /// The recording can be read, and not all of it is there or as the recorder writes it.
    #[error("{warning}")]
    Warned {
        /// Text of the reader's warning.
        warning: String,
    },
    /// The description is of another trial, session or participant than the folder's name.
    #[error("recording.toml is of {found}, and the folder of {expected}")]
    OtherTrial {
        /// Trial in the description.
        found: String,
        /// Trial by the folders' names.
        expected: String,
    },
    /// The log calls the trial saved or settled, and its description has no `end`.
    #[error("recording.toml has no `end`, though the log says that the trial ended")]
    NoEnd,
    /// The log calls the trial broken off, and its description calls it complete.
    #[error("recording.toml says that the trial is complete, and the log that it was broken off")]
    OtherEnd,
    /// The log calls the trial accepted, and its recording was broken off.
    #[error(
        "the log says that the trial was accepted, and recording.toml that its recording was broken off"
    )]
    AcceptedBrokenOff,
    /// The log calls the trial accepted, and never its recording saved.
    #[error("the log says that the trial was accepted, and not that its recording was saved")]
    AcceptedUnsaved,
    /// The log marks other intervals of an accepted trial than its recording has.
    #[error(
        "the log marks {marked} intervals of the accepted trial, and recording.toml has {recorded}"
    )]
    OtherIntervals {
        /// Number by the log.
        marked: usize,
        /// Number in the description.
        recorded: usize,
    },
    /// A sensor has no readings of part of an accepted trial.
    #[error(
        "{file} has no rows from {from_s:.3} to {to_s:.3} s, although the trial was accepted and recording.toml names its sensor"
    )]
    NoRowsOf {
        /// The file.
        file: &'static str,
        /// Start of the part of an exploration, s.
        from_s: f64,
        /// Its end, s.
        to_s: f64,
    },
    /// Samples where the description says that frames were lost, or no frames at all.
    #[error(
        "recording.toml says that {frames} frames from {sample} on were lost, but signals.wav has samples there"
    )]
    GapWithSamples {
        /// First frame of the gap.
        sample: u64,
        /// Frames of the gap.
        frames: u64,
    },
    /// Frames without a value that no event explains.
    #[error("{frames} frames of signals.wav are lost, and no event of recording.toml says so")]
    UnexplainedLoss {
        /// Number of the frames.
        frames: u64,
    },
    /// The log does not know the recording.
    #[error("the log does not know it: it was put here, or lines of the log are missing")]
    NotInLog,
}

/// What is wrong with a session beside its recordings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SessionDefect {
    /// There are recordings and no log.
    #[error("events.jsonl is missing")]
    NoLog,
    /// The log cannot be read.
    #[error("{reason}")]
    Unreadable {
        /// Error text of the reader.
        reason: String,
    },
    /// The log does not begin with a start, or goes on without one after a stop.
    #[error(
        "events.jsonl, document {document}: an event or a stop before any start; lines are missing or in another order"
    )]
    NoStart {
        /// The document, from 1.
        document: usize,
    },
    /// Numbers of events are missing, double or in another order.
    #[error(
        "events.jsonl: event {found} follows where event {expected} belongs: lines are missing or in another order"
    )]
    Number {
        /// Number that belongs here.
        expected: u64,
        /// Number that is here.
        found: u64,
    },
    /// The audio clock goes back between two events.
    #[error(
        "events.jsonl, event {number}: its time {audio_s} s is before the last event's, {before_s} s"
    )]
    Time {
        /// The event.
        number: u64,
        /// Its time, s.
        audio_s: f64,
        /// Time of the event before it, s.
        before_s: f64,
    },
    /// The stream of an event has no descriptor.
    #[error("events.jsonl, event {number}: stream `{stream}` has no descriptor before it")]
    Undescribed {
        /// The event.
        number: u64,
        /// Its stream.
        stream: String,
    },
    /// A stop counts other events than there are.
    #[error("events.jsonl: {found} events before a stop that counts {expected}: lines are missing")]
    Count {
        /// Number by the stop.
        expected: u64,
        /// Number in the log.
        found: u64,
    },
    /// A stop calls the session complete before all of its trials were settled.
    #[error(
        "events.jsonl calls the session complete, and {settled} of its {planned} trials were settled"
    )]
    NotAllSettled {
        /// Trials in the session's order.
        planned: usize,
        /// Those that were settled.
        settled: usize,
    },
    /// A trial was begun, settled or saved out of order.
    #[error("events.jsonl, event {number}: {trial} {what}")]
    Order {
        /// The event.
        number: u64,
        /// The trial.
        trial: TrialLabel,
        /// What is out of order.
        what: &'static str,
    },
    /// The log is of another participant or session than its folder.
    #[error("events.jsonl is of {found}, and the folder of {expected}")]
    OtherSession {
        /// Participant and session of the log.
        found: String,
        /// Participant and session by the folders' names.
        expected: String,
    },
    /// A file that the session keeps a copy of is missing.
    #[error("{file} is missing: the session's copy of it")]
    NoCopy {
        /// The file.
        file: String,
    },
    /// A file that the session keeps a copy of is not TOML.
    #[error("{file} cannot be read: {reason}")]
    BrokenCopy {
        /// The file.
        file: String,
        /// Error text of the parser.
        reason: String,
    },
    /// A folder holds a recording that is no trial of this session.
    #[error("{name} is a recording that is no trial of this session; it was put here")]
    ForeignRecording {
        /// Name of the folder.
        name: String,
    },
}

impl SessionDefect {
    /// Returns whether trials may be hidden by it: lines of the log are missing or not where they belong.
    #[must_use]
    pub fn hides_trials(&self) -> bool {
        matches!(
            self,
            Self::NoStart { .. } | Self::Number { .. } | Self::Count { .. } | Self::Order { .. }
        )
    }
}

/// What is wrong with a study beside its sessions.
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
    /// `exclusions.tsv` cannot be used, so nothing is analysed.
    #[error("{reason}")]
    Exclusions {
        /// Why not.
        reason: String,
    },
    /// A participant of `participants.tsv` has no folder.
    #[error("participants.tsv lists {participant}, and there is no folder of that name")]
    NoParticipant {
        /// The participant.
        participant: String,
    },
}
