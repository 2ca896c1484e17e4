//! Why a recording cannot be read, its defects where it can, and the limits of its rows.

use std::io;
use std::path::PathBuf;

use crate::manifest::ManifestReadError;
use crate::wav::{WavError, WavWarning};
use crate::{MANIFEST_FILE, SIGNALS_FILE};

/// Most rows in a second of a recording: no sensor of force or position is that fast.
pub const MAX_ROWS_PER_S: u64 = 100_000;
/// Most bytes of a row in the mean over a file.
pub const MEAN_ROW_BYTES: u64 = 256;
/// Most bytes of a single row; a longer one is unreadable.
pub const MAX_ROW_BYTES: usize = 4096;
/// Time outside the recording beyond which a row is left out, s: sensors go on for a moment when the audio has ended.
pub const OUTSIDE_S: f64 = 2.0;

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// A file of the recording is missing, or the operating system refused.
    #[error("cannot read {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason; not a `source`, because the message contains it.
        reason: io::Error,
    },
    /// A file of rows has more of them than any sensor gives in the time of the recording.
    #[error(
        "{}: more than {limit_rows} rows in a recording of {duration_s:.3} s; at most {MAX_ROWS_PER_S} a second are read",
        path.display()
    )]
    TooManyRows {
        /// The file.
        path: PathBuf,
        /// The most rows that are read.
        limit_rows: u64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// A file of rows is longer than its rows can be.
    #[error(
        "{}: more than {limit_bytes} bytes in a recording of {duration_s:.3} s; \
         at most {MAX_ROWS_PER_S} rows a second of {MEAN_ROW_BYTES} bytes in the mean are read",
        path.display()
    )]
    RowsTooLong {
        /// The file.
        path: PathBuf,
        /// The most bytes that are read.
        limit_bytes: u64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// `recording.toml` is not one, or does not fit the audio.
    #[error(transparent)]
    Manifest(#[from] ManifestReadError),
    /// `signals.wav` cannot be read.
    #[error("{}: {reason}", path.display())]
    Wav {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: WavError,
    },
    /// A CSV file lacks a column.
    #[error(
        "{}: no column `{column}`; its header is `{header}`, columns are separated by commas",
        path.display()
    )]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// The header found.
        header: String,
    },
}

/// Defect of a recording that can be read nevertheless.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A defect of the audio file.
    #[error("{SIGNALS_FILE}: {0}")]
    Signals(#[from] WavWarning),
    /// An interval ends after the last sample.
    #[error(
        "{MANIFEST_FILE}: `intervals.{index}` ends at {end_s} s, but the recording ends at {duration_s} s"
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
    /// Rows are left out because a field is missing or no number, because they have more fields than the header (as
    /// where the decimal sign is a comma), or because the last line has no end and may be torn.
    #[error(
        "{file}: {rows} rows cannot be read and are left out, the first in line {first_line}: `{first}`"
    )]
    UnreadableRows {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
        /// Beginning of that line.
        first: String,
    },
    /// Rows are left out because their time does not increase.
    #[error(
        "{file}: {rows} rows are left out because their time does not increase, the first in line {first_line}"
    )]
    TimeDisorder {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
    },
    /// Rows are left out because their time leaps ahead of the rows that follow.
    #[error(
        "{file}: {rows} rows are left out because their time leaps ahead of the rows that follow, the first in line {first_line}"
    )]
    TimeLeap {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
    },
    /// Rows are left out because their time is outside the recording's.
    #[error(
        "{file}: {rows} rows are left out because their time is more than {OUTSIDE_S} s outside the recording, 0 to {duration_s:.3} s, the first in line {first_line}"
    )]
    OutsideRecording {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
        /// Least of their times, s.
        from_s: f64,
        /// Greatest of their times, s.
        to_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// Rows have a value that is not finite; they are read.
    #[error(
        "{file}: {rows} rows have a value that is NaN or infinite, the first in line {first_line}"
    )]
    NotFinite {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
    },
    /// No row could be read.
    #[error(
        "{file}: no row can be read; columns are separated by commas, and the decimal sign is a point"
    )]
    NoRows {
        /// The file.
        file: &'static str,
    },
}
