//! A file beyond the end of which reading fails.
//!
//! The library goes on for hours in a damaged header at the end of a file that returns no bytes.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::sync::Arc;

use bytes::Bytes;
use file_sections::Section;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, Length};

/// File that is read by the library.
pub(super) struct StrictFile(Section);

impl StrictFile {
    /// Creates the source of a file.
    pub(super) fn new(file: File) -> io::Result<Self> {
        let n_bytes = file.metadata()?.len();
        Ok(Self(Section::new(Arc::new(file), 0, n_bytes)))
    }
}

/// Bytes of a file from an offset on.
pub(super) struct StrictEnd(Section);

impl Read for StrictEnd {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer)? {
            0 if !buffer.is_empty() => Err(io::ErrorKind::UnexpectedEof.into()),
            count => Ok(count),
        }
    }
}

impl Length for StrictFile {
    fn len(&self) -> u64 {
        self.0.len()
    }
}

impl ChunkReader for StrictFile {
    type T = BufReader<StrictEnd>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        Ok(BufReader::new(StrictEnd(self.0.part(start, self.0.len()))))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        let part = self.0.part(start, start.saturating_add(length as u64));
        if part.len() < length as u64 {
            return Err(ParquetError::EOF("beyond the end of the file".to_owned()));
        }
        let mut bytes = vec![0; length];
        StrictEnd(part).read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}
