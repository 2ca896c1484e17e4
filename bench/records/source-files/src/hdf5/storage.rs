//! The file, read in pieces of bounded size.

use std::fs::File;
use std::io;

use hdf5_reader::error::{Error, Result};
use hdf5_reader::{FileStorage, Storage, StorageBuffer};

/// Largest piece, bytes: a compressed chunk may be a little larger than the chunk.
const MOST_BYTES: usize = 260 << 20;

/// A file that refuses to read a larger piece than any array needs.
pub(crate) struct BoundedFile(FileStorage);

impl BoundedFile {
    pub(crate) fn new(file: File) -> io::Result<Self> {
        let storage = FileStorage::from_file(file);
        storage.map(Self).map_err(|error| match error {
            Error::Io(error) => error,
            other => io::Error::other(other),
        })
    }
}

impl Storage for BoundedFile {
    fn len(&self) -> u64 {
        self.0.len()
    }

    fn read_range(&self, offset: u64, length: usize) -> Result<StorageBuffer> {
        if length > MOST_BYTES {
            return Err(Error::ResourceLimit(format!("{length} bytes at once")));
        }
        self.0.read_range(offset, length)
    }
}
