//! Failures while the content of an exported file is made.

use std::io;

use recording::reader::ReadError;

/// Failure while the content of an exported file is made.
#[derive(Debug)]
pub(crate) enum FillError {
    /// The file cannot be written.
    Write(io::Error),
    /// The recording cannot be read.
    Read(ReadError),
    /// The recording has another length than before.
    Changed,
}

impl From<io::Error> for FillError {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

impl From<ReadError> for FillError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}
