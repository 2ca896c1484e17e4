//! The file, read in pieces of bounded size.

use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use hdf5_reader::error::{Error, Result};
use hdf5_reader::{FileStorage, Storage, StorageBuffer};

/// Bytes of a message with the start of a layout.
const MESSAGE_BYTES: usize = 16;

/// Largest piece, bytes: a compressed chunk may be a little larger than the chunk.
const MOST_BYTES: usize = 260 << 20;

/// A file that refuses to read a larger piece than any array needs.
///
/// While the structure is listed, layouts of version 2 are passed on as those of version 1, which differ in that number alone:
/// hdf5-reader 0.12.1 takes two bytes too few of version 2, as HDF5 1.6 and MATLAB R2006b to R2007b wrote it.
pub(crate) struct BoundedFile {
    file: FileStorage,
    is_listing: AtomicBool,
}

impl BoundedFile {
    pub(crate) fn new(file: File) -> io::Result<Self> {
        let storage = FileStorage::from_file(file);
        let file = storage.map_err(|error| match error {
            Error::Io(error) => error,
            other => io::Error::other(other),
        })?;
        Ok(Self {
            file,
            is_listing: AtomicBool::new(true),
        })
    }

    /// Passes bytes on as they are from here on: the structure is known.
    pub(crate) fn end_listing(&self) {
        self.is_listing.store(false, Ordering::Relaxed);
    }
}

/// Returns the offsets of the version numbers of layouts of version 2, in messages of objects' headers of version 1.
fn layouts(bytes: &[u8]) -> impl Iterator<Item = usize> {
    let places = (0..bytes.len().saturating_sub(MESSAGE_BYTES)).step_by(8);
    places.filter_map(|place| {
        // Type, size, flags; then version, number of axes, class, five bytes that are 0.
        let [
            8,
            0,
            low,
            high,
            _,
            0,
            0,
            0,
            2,
            axes,
            1..=2,
            0,
            0,
            0,
            0,
            0,
            ..,
        ] = bytes[place..]
        else {
            return None;
        };
        let stated = usize::from(u16::from_le_bytes([low, high]));
        let needed = 16 + 4 * usize::from(axes);
        let fits = (1..=33).contains(&axes) && stated == needed.next_multiple_of(8);
        fits.then_some(place + 8)
    })
}

impl Storage for BoundedFile {
    fn len(&self) -> u64 {
        self.file.len()
    }

    fn read_range(&self, offset: u64, length: usize) -> Result<StorageBuffer> {
        if length > MOST_BYTES {
            return Err(Error::ResourceLimit(format!("{length} bytes at once")));
        }
        let bytes = self.file.read_range(offset, length)?;
        let found: Vec<usize> = layouts(bytes.as_ref()).collect();
        if found.is_empty() || !self.is_listing.load(Ordering::Relaxed) {
            return Ok(bytes);
        }
        let mut changed = bytes.as_ref().to_vec();
        for place in found {
            changed[place] = 1;
        }
        Ok(StorageBuffer::from_vec(changed))
    }
}
