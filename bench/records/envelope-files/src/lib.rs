//! `envelopes.parquet`: complex envelopes of drive and pickup, as a lock-in amplifier keeps them. Peak values, exp(+iωt).
//!
//! ```
//! use envelope_files::{EnvelopeReader, EnvelopeRow, EnvelopeWriter};
//! use num_complex::Complex64;
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("envelopes.parquet");
//! let row = EnvelopeRow {
//!     time_s: 0.0,
//!     drive_v: Complex64::new(20.0, 1.0),
//!     pickup_m: Complex64::new(0.0, -2e-6),
//! };
//! let mut writer = EnvelopeWriter::create(&path)?;
//! writer.write(&[row])?;
//! writer.finish()?;
//!
//! let mut reader = EnvelopeReader::open(&path)?;
//! let mut rows = Vec::new();
//! assert_eq!(reader.read(1024, &mut rows)?, 1);
//! assert_eq!(rows, [row]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod even_rows;
mod reader;
mod writer;

use std::path::PathBuf;

use num_complex::Complex64;
use parquet::errors::ParquetError;

pub use even_rows::EvenRows;
pub use reader::EnvelopeReader;
pub use writer::EnvelopeWriter;

/// Names of the columns.
pub const COLUMNS: [&str; 5] = [
    "time_s",
    "drive_re_v",
    "drive_im_v",
    "pickup_re_m",
    "pickup_im_m",
];

/// Envelopes at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeRow {
    /// Time from the start of the recording, s.
    pub time_s: f64,
    /// Voltage across the actuators, V; NaN if lost.
    pub drive_v: Complex64,
    /// Displacement of the plate, m; NaN if lost.
    pub pickup_m: Complex64,
}

/// Error of reading or writing envelopes.
#[derive(Debug, thiserror::Error)]
pub enum EnvelopeError {
    /// The operating system refused.
    #[error("{}: {}", path.display(), bounded_files::cause(reason))]
    Io {
        /// The file.
        path: PathBuf,
        /// Reason; not a `source`, because the message contains it.
        reason: std::io::Error,
    },
    /// The file does not exist.
    #[error(
        "{} does not exist: a recording with a carrier and without `[channels]` has its envelopes there; describe those of signals.wav \
         in `[channels]`",
        path.display()
    )]
    Absent {
        /// The file.
        path: PathBuf,
    },
    /// The file is not Parquet, is damaged, or has a compression that is not read.
    #[error(
        "{}: it cannot be read as Parquet: it may be damaged, copied in part, or compressed by another method than snappy; write it again \
         without compression or with snappy",
        path.display()
    )]
    Parquet {
        /// The file.
        path: PathBuf,
        /// Reason of the reader.
        #[source]
        reason: ParquetError,
    },
    /// A column is missing.
    #[error(
        "{}: the column `{column}` is missing; the columns are time_s, drive_re_v, drive_im_v, pickup_re_m, pickup_im_m",
        path.display()
    )]
    NoColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A column has no floating-point numbers.
    #[error("{}: the column `{column}` has no numbers of 64 or 32 bits; write it as double", path.display())]
    NoNumbers {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// Fewer than two rows have a time.
    #[error("{}: fewer than two rows have a time", path.display())]
    TooFewRows {
        /// The file.
        path: PathBuf,
    },
    /// Times are uneven.
    #[error(
        "{}: `time_s` is uneven: row {row} is at {time_s:.6} s, not at {expected_s:.6} s as at the rate of {rate_hz:.3} Hz before; \
         resample the envelopes at an even rate, with NaN where they are missing",
        path.display()
    )]
    Uneven {
        /// The file.
        path: PathBuf,
        /// Number of the row, from 1.
        row: u64,
        /// Its time, s.
        time_s: f64,
        /// Time at an even rate, s.
        expected_s: f64,
        /// Rate of the rows before, Hz.
        rate_hz: f64,
    },
}
