//! What the recorder is told, and what it answers.

use std::path::PathBuf;

use crate::csv_rows::{ForceRow, PositionRow};
use crate::disk::DiskError;
use crate::manifest::{Manifest, RecordedClock, RecordedInterval, RecordingEvent};
use crate::sums::Sums;
use crate::wav::AudioFormat;
use crate::writer::{Ending, OnDisk, WriteError};

/// Message from the acquisition to the recorder.
#[derive(Debug)]
pub enum RecorderMessage {
    /// Starts a recording in a folder that does not exist yet.
    Begin(Box<Begin>),
    /// Interleaved samples.
    Audio(Vec<f32>),
    /// Number of frames that were lost.
    Gap(u64),
    /// Force readings on the audio clock.
    Force(Vec<ForceRow>),
    /// Position readings on the audio clock.
    Position(Vec<PositionRow>),
    /// An event.
    Event(RecordingEvent),
    /// An event that may go on: replaces the event of the flag of this number, if there is one.
    Flag(u64, RecordingEvent),
    /// Clocks that readings are placed by; they replace what was known of them.
    Clocks(Vec<RecordedClock>),
    /// An interval with a known meaning.
    Interval(RecordedInterval),
    /// Ends the recording.
    End(Ending),
}

/// Recording to begin.
#[derive(Debug)]
pub struct Begin {
    /// Folder of the recording, which must not exist; its parent must.
    pub folder: PathBuf,
    /// Description of the recording.
    pub manifest: Manifest,
    /// Format of the audio.
    pub format: AudioFormat,
}

/// Answer of the recorder; answers come in order.
#[derive(Debug)]
pub enum RecorderNotice {
    /// The folder is on disk and takes data.
    Began {
        /// The recording.
        folder: PathBuf,
    },
    /// The recording has ended and is synced, and was read back. It may come after the next recording began.
    Saved {
        /// The recording.
        folder: PathBuf,
        /// What the recording holds.
        on_disk: OnDisk,
        /// Sums of its files; `None` if the recorder ended before it had read them.
        sums: Option<Sums>,
        /// Whether the trial was broken off.
        interrupted: bool,
    },
    /// The recording failed; later data up to the next `Begin` are discarded.
    Failed {
        /// The recording.
        folder: PathBuf,
        /// Reason.
        error: RecorderError,
        /// What of it is readable.
        kept: OnDisk,
    },
}

/// Why a recording failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file that was written and synced cannot be read.
    #[error("the recording was written, but its files cannot be read again: {0}")]
    ReadBack(#[from] DiskError),
    /// The disk was slower than the data for longer than the queue holds.
    #[error(
        "the recorder's queue overflowed: {messages} messages with {frames} frames of audio were lost after frame {at_frame}; the disk is too slow"
    )]
    Overflow {
        /// Messages lost.
        messages: u64,
        /// Frames of audio among them.
        frames: u64,
        /// Frames recorded before.
        at_frame: u64,
    },
    /// A recording was begun before the last one had ended.
    #[error("the next recording began before this one had ended")]
    NotEnded,
    /// The acquisition ended without ending the recording, by a panic for example.
    #[error("the acquisition ended before the recording had ended")]
    Disconnected,
}

/// State of the recorder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RecorderState {
    /// No recording is open.
    #[default]
    Idle,
    /// A recording is being written.
    Recording,
    /// The last recording failed.
    Failed,
}

/// Snapshot of the recorder for the screen.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecorderStatus {
    /// State of the recorder.
    pub state: RecorderState,
    /// The current or the last recording.
    pub folder: Option<PathBuf>,
    /// Frames taken, on disk or not.
    pub frames: u64,
    /// What the last sync put on disk.
    pub on_disk: OnDisk,
    /// Why the last recording failed.
    pub error: Option<String>,
}
