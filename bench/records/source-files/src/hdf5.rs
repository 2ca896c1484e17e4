//! HDF5, and the arrays of MATLAB v7.3 within it: listed from the file's structure, read by slabs.
//!
//! The structure is read by `hdf5-reader`. Its panics, if a damaged file makes any, end in a refusal ([`guard`]), and reads are of
//! bounded size ([`storage`]).

pub(crate) mod attributes;
pub(crate) mod column;
pub(crate) mod guard;
mod links;
pub(crate) mod listing;
mod lzf;
mod number;
mod plain;
mod storage;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use hdf5_reader::filters::FilterRegistry;
use hdf5_reader::{Hdf5File, OpenOptions};

use crate::array::{ArrayInfo, Attribute};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values};
use crate::matlab73;
use guard::guarded;
use listing::{Content, Listing};
use storage::BoundedFile;

/// Chunks that stay decompressed, bytes.
const CHUNK_CACHE_BYTES: usize = 32 << 20;
/// Largest chunk that is read, bytes.
const MOST_CHUNK_BYTES: usize = 256 << 20;
/// Largest header of an object, bytes.
const MOST_HEADER_BYTES: usize = 8 << 20;
/// First bytes of MATLAB's header of a file of version 7.3.
const MATLAB: &[u8] = b"MATLAB ";

/// Opens an HDF5 file, or one of MATLAB v7.3.
pub(crate) fn open(mut file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
    let mut head = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    Read::by_ref(&mut file)
        .take(MATLAB.len() as u64)
        .read_to_end(&mut head)?;
    let storage = Arc::new(BoundedFile::new(file)?);
    let with_cache = |cache_bytes| -> Result<(Format, Listing), SourceError> {
        let hdf5 = guarded("header", || {
            Hdf5File::from_storage_with_options(Arc::clone(&storage) as _, options(cache_bytes))
        })?;
        if head == MATLAB || matlab73::is_matlab(&hdf5)? {
            Ok((Format::Matlab73, matlab73::list(&hdf5)?))
        } else {
            Ok((Format::Hdf5, plain::list(&hdf5)?))
        }
    };
    let (mut format, mut listing) = with_cache(CHUNK_CACHE_BYTES)?;
    // A chunk that does not stay would be decompressed anew for each stretch.
    let largest = listing.largest_chunk_bytes();
    if largest > CHUNK_CACHE_BYTES && largest <= MOST_CHUNK_BYTES {
        (format, listing) = with_cache(largest)?;
    }
    storage.end_listing();
    Ok(Box::new(Hdf5Reader::new(format, listing)))
}

fn options(cache_bytes: usize) -> OpenOptions {
    let mut filters = FilterRegistry::new();
    filters.register(lzf::FILTER, Box::new(lzf::decompress));
    OpenOptions::default()
        .with_chunk_cache_bytes(cache_bytes)
        .with_max_chunk_bytes(MOST_CHUNK_BYTES)
        .with_max_read_bytes(MOST_CHUNK_BYTES)
        .with_max_object_header_bytes(MOST_HEADER_BYTES)
        .with_filter_registry(filters)
}

struct Hdf5Reader {
    format: Format,
    arrays: Vec<ArrayInfo>,
    contents: Vec<Content>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

impl Hdf5Reader {
    fn new(format: Format, listing: Listing) -> Self {
        let (arrays, contents) = listing.arrays.into_iter().unzip();
        Self {
            format,
            arrays,
            contents,
            attributes: listing.attributes,
            notes: listing.notes,
        }
    }

    fn content(&self, index: usize) -> Result<(String, &Content), SourceError> {
        let name = self.arrays.get(index).map_or("", |info| &info.name);
        let place = format!("array `{name}`");
        match self.contents.get(index) {
            Some(content) => Ok((place, content)),
            None => Err(SourceError::damaged(place, "it is missing")),
        }
    }
}

impl ArrayReader for Hdf5Reader {
    fn format(&self) -> Format {
        self.format
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn text(&mut self, index: usize) -> Result<Option<String>, SourceError> {
        let (place, content) = self.content(index)?;
        match content {
            Content::Text(text) => guarded(&place, || text.read()),
            _ => Ok(None),
        }
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let (name, content) = self.content(index)?;
        match content {
            Content::Numbers(column) => {
                guarded(&name, || column.read(place, range.clone(), values))
            }
            Content::Ramp { first, step } => {
                for n in range {
                    values.push(first + step * n as f64);
                }
                Ok(())
            }
            // Without elements, or not numeric.
            Content::Empty | Content::Text(_) | Content::Opaque => Ok(()),
        }
    }
}
