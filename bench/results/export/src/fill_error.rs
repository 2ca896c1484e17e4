//! Failures while the content of an exported file is made.

use std::io;

use envelope_files::EnvelopeError;
use recording::reader::ReadError;

/// Failure while the content of an exported file is made.
#[derive(Debug)]
pub(crate) enum FillError {
    /// The file cannot be written.
    Write(io::Error),
    /// The recording cannot be read.
    Read(ReadError),
    /// Its envelopes cannot be read.
    Envelopes(EnvelopeError),
    /// The recording has another length than before.
    Changed,
}

impl From<io::Error> for FillError {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

impl From<EnvelopeError> for FillError {
    fn from(error: EnvelopeError) -> Self {
        Self::Envelopes(error)
    }
}

impl From<ReadError> for FillError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}
