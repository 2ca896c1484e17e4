//! Errors of writing tables.

use std::path::PathBuf;

use analysis::SeriesError;
use recording::DiskError;

/// Reasons why the tables cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The operating system reported an error.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The series cannot be read.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// The table cannot be encoded.
    #[error("cannot make {}: {reason}", path.display())]
    Encode {
        /// Path of the file.
        path: PathBuf,
        /// Reason of the failure.
        reason: Box<dyn std::error::Error + Send + Sync>,
    },
}
