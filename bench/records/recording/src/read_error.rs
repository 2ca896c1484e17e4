//! Errors and defects of reading a recording, and limits of its rows.

use std::io;
use std::path::PathBuf;

use text_tables::TableFault;

use crate::manifest::{Manifest, ManifestReadError};
use crate::{FileName, MANIFEST_FILE, SIGNALS_FILE, file_name};
use serde::{Deserialize, Serialize};
use wav_files::{WavError, WavWarning};

/// Maximum number of rows per second of a recording; no force or position sensor is that fast.
pub const MAX_ROWS_PER_S: u64 = 100_000;
/// Maximum mean number of bytes per row of a file.
pub const MEAN_ROW_BYTES: u64 = 256;
/// Maximum number of bytes of a single row; longer rows are unreadable.
pub const MAX_ROW_BYTES: usize = 4096;
/// Time outside the recording beyond which a row is omitted, s: sensors continue for a moment after the audio.
pub const OUTSIDE_S: f64 = 2.0;

/// Time before the end of the recording from which on the last row is early, s: no usual sensor is that slow.
pub const EARLY_END_S: f64 = 0.25;

/// Error of reading a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// A file of the recording is missing, or the operating system refused.
    #[error("cannot read {}: {}", path.display(), bounded_files::cause(reason))]
    Io {
        /// The file.
        path: PathBuf,
        /// Reason; not a `source`, because the message contains it.
        reason: io::Error,
    },
    /// A file of rows does not exist.
    #[error("{} does not exist: {remedy}", path.display())]
    Absent {
        /// The file.
        path: PathBuf,
        /// Source of its rows where the sensor is missing.
        remedy: &'static str,
    },
    /// The recording has no raw signals.
    #[error(
        "{}: without `[channels]` the recording has no drive and pickup as sampled, which are needed here; `analyze` reads it",
        path.display()
    )]
    NoSignals {
        /// The manifest.
        path: PathBuf,
    },
    /// A file has more rows than any sensor gives in the time of the recording.
    #[error(
        "{}: more than {limit_rows} rows in a recording of {duration_s:.3} s; at most {MAX_ROWS_PER_S} a second are read",
        path.display()
    )]
    TooManyRows {
        /// The file.
        path: PathBuf,
        /// Maximum number of rows.
        limit_rows: u64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// A file is longer than its rows can be.
    #[error(
        "{}: more than {limit_bytes} bytes in a recording of {duration_s:.3} s; \
         at most {MAX_ROWS_PER_S} rows a second of {MEAN_ROW_BYTES} bytes in the mean are read",
        path.display()
    )]
    RowsTooLong {
        /// The file.
        path: PathBuf,
        /// Limit, bytes.
        limit_bytes: u64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// `recording.toml` is invalid or does not match the audio.
    #[error(transparent)]
    Manifest(#[from] ManifestReadError),
    /// `signals.wav` cannot be read.
    #[error("{}: {reason}", path.display())]
    Wav {
        /// The file.
        path: PathBuf,
        /// Reason.
        reason: WavError,
    },
    /// A CSV file has a fault that concerns all its rows.
    #[error("{}: {fault}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Fault.
        fault: TableFault,
    },
    /// The analysis was asked to stop.
    #[error("the analysis was stopped")]
    Stopped,
}

impl ReadError {
    /// Returns the error with a remedy if its file does not exist.
    pub(crate) fn or_absent(self, remedy: &'static str) -> Self {
        match self {
            Self::Io { path, reason } if reason.kind() == io::ErrorKind::NotFound => {
                Self::Absent { path, remedy }
            }
            error => error,
        }
    }
}

/// Defect of a recording that can still be read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// The audio file has a defect.
    #[error("{SIGNALS_FILE}: {0}")]
    Signals(#[from] WavWarning),
    /// An interval ends after the last sample.
    #[error(
        "{MANIFEST_FILE}: `intervals.{index}` ends at {end_s:.3} s, but the recording ends at {duration_s:.3} s"
    )]
    IntervalBeyondEnd {
        /// Position in the list, from 0.
        index: usize,
        /// End of the interval, s.
        end_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// The trial did not end.
    #[error("{MANIFEST_FILE}: the trial has no `end`: its recording was cut off")]
    CutOff,
    /// Rows are omitted because a field is missing or not a number, because they have more fields than the header (as
    /// with a decimal comma), or because the last line has no end and may be torn.
    #[error(
        "{file}: {rows} rows cannot be read and are left out, the first in line {first_line}: `{first}`"
    )]
    UnreadableRows {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Number of rows.
        rows: u64,
        /// Line of the first one.
        first_line: u64,
        /// Beginning of that line.
        first: String,
    },
    /// Rows are omitted because their time does not increase.
    #[error(
        "{file}: {rows} rows are left out because their time does not increase, the first in line {first_line}"
    )]
    TimeDisorder {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Number of rows.
        rows: u64,
        /// Line of the first one.
        first_line: u64,
    },
    /// Rows are omitted because their time is ahead of the following rows.
    #[error(
        "{file}: {rows} rows are left out because their time leaps ahead of the rows that follow, the first in line {first_line}"
    )]
    TimeLeap {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Number of rows.
        rows: u64,
        /// Line of the first one.
        first_line: u64,
    },
    /// Rows are omitted because their time is outside the recording.
    #[error(
        "{file}: {rows} rows are left out because their time is more than {OUTSIDE_S} s outside the recording, 0 to {duration_s:.3} s, the first in line {first_line}"
    )]
    OutsideRecording {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Number of rows.
        rows: u64,
        /// Line of the first one.
        first_line: u64,
        /// Earliest of their times, s.
        from_s: f64,
        /// Latest of their times, s.
        to_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// Rows contain a value that is not finite; they are read.
    #[error(
        "{file}: {rows} rows have a value that is NaN or infinite, the first in line {first_line}"
    )]
    NotFinite {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Number of rows.
        rows: u64,
        /// Line of the first one.
        first_line: u64,
    },
    /// Rows contain NUL characters instead of text.
    #[error(
        "{file}: zeros instead of text from line {first_line} on, as a broken-off copy or a power cut leaves them; copy the file again from \
         the computer that recorded it"
    )]
    ZeroedRows {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Line of the first one.
        first_line: u64,
    },
    /// The last row is earlier than the end of the recording.
    #[error(
        "{file}: it ends at {last_s:.3} s, and the recording at {duration_s:.3} s: the file was copied in part, or the sensor fell \
         silent; compare it with the original"
    )]
    EndsEarly {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Time of the last row, s.
        last_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// No row can be read.
    #[error("{file}: no row can be read below its header")]
    NoRows {
        /// The file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
    },
}

impl Warning {
    /// Returns the defects that the description of a recording of `duration_s` shows.
    pub(crate) fn of_description(manifest: &Manifest, duration_s: f64) -> Vec<Self> {
        let is_cut_off = manifest
            .trial
            .as_ref()
            .is_some_and(|trial| trial.end.is_none());
        let intervals = manifest.intervals.iter().enumerate();
        let late_intervals = intervals
            .filter(|(_, interval)| interval.end_s > duration_s)
            .map(|(index, interval)| Self::IntervalBeyondEnd {
                index,
                end_s: interval.end_s,
                duration_s,
            });
        let cut_off = is_cut_off.then_some(Self::CutOff);
        cut_off.into_iter().chain(late_intervals).collect()
    }
}
