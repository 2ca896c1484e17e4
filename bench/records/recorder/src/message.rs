//! Messages to the recorder and its answers.

use std::path::PathBuf;

use recording::disk::DiskError;
use recording::manifest::{Manifest, RecordedClock, RecordedInterval, RecordingEvent};
use recording::sums::Sums;
use recording::writer::{DiskSize, Ending, WriteError};
use recording::{ForceRow, PositionRow};
use wav_files::AudioFormat;

/// Message from the acquisition to the recorder.
#[derive(Debug)]
pub enum RecorderMessage {
    /// Starts a recording in a folder that does not exist yet.
    Begin(Box<Begin>),
    /// Interleaved samples.
    Audio(Vec<f32>),
    /// Number of lost frames.
    Gap(u64),
    /// Force readings on the audio clock.
    Force(Vec<ForceRow>),
    /// Position readings on the audio clock.
    Position(Vec<PositionRow>),
    /// An event.
    Event(RecordingEvent),
    /// Event that may continue: replaces the event of the same flag, if there is one.
    Flag(u64, RecordingEvent),
    /// Clocks that give the times of readings; they replace the previous ones.
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

/// Answer of the recorder; answers arrive in order.
#[derive(Debug)]
pub enum RecorderNotice {
    /// The folder is on disk and accepts data.
    Began {
        /// The recording.
        folder: PathBuf,
    },
    /// The recording has ended, is synced and was read back. This may arrive after the start of the next recording.
    Saved {
        /// The recording.
        folder: PathBuf,
        /// Size of the recording.
        on_disk: DiskSize,
        /// Sums of its files; `None` if the recorder ended before reading them.
        sums: Option<Sums>,
        /// Whether the trial was interrupted.
        interrupted: bool,
    },
    /// The recording failed; later data up to the next `Begin` are discarded.
    Failed {
        /// The recording.
        folder: PathBuf,
        /// Reason.
        error: RecorderError,
        /// Size of the readable part.
        saved_part: DiskSize,
    },
}

/// Error of a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A written and synced file cannot be read.
    #[error("the recording was written, but its files cannot be read again: {0}")]
    ReadBack(#[from] DiskError),
    /// The disk was slower than the data for longer than the queue can bridge.
    #[error(
        "the recorder's queue overflowed: {messages} messages with {frames} frames of audio were lost after frame {at_frame}; the disk is too slow"
    )]
    Overflow {
        /// Number of lost messages.
        messages: u64,
        /// Number of lost audio frames.
        frames: u64,
        /// Number of frames recorded before the loss.
        at_frame: u64,
    },
    /// A recording began before the previous one ended.
    #[error("the next recording began before this one had ended")]
    NotEnded,
    /// The acquisition ended without ending the recording, for example by a panic.
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
    /// Current or last recording.
    pub folder: Option<PathBuf>,
    /// Frames accepted, whether on disk or not.
    pub frames: u64,
    /// Size on disk at the last sync.
    pub on_disk: DiskSize,
    /// Error of the last recording, if it failed.
    pub error: Option<String>,
}
