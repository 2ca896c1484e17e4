//! Refusals in place of the reader's errors and panics.

use hdf5_reader::error::Error;

use crate::error::{SourceError, SourceFault};

/// Calls the reader; its errors, and a panic on a damaged file, become a refusal at `place`.
pub(crate) fn guarded<T>(
    place: &str,
    call: impl FnOnce() -> hdf5_reader::error::Result<T>,
) -> Result<T, SourceError> {
    match decoder_panics::guarded(call) {
        Some(result) => result.map_err(|error| refusal(place, error)),
        None => Err(contradictory(place)),
    }
}

fn contradictory(place: &str) -> SourceError {
    SourceError::damaged(place, "HDF5's structure contradicts itself here")
}

/// Layout of an array whose numbers are in others.
const VIRTUAL: u8 = 3;

/// Filters that others register with HDF5, and their names.
const FILTERS: [(&str, &str); 11] = [
    ("307", "bzip2"),
    ("32000", "LZF"),
    ("32001", "Blosc"),
    ("32004", "LZ4"),
    ("32008", "bitshuffle"),
    ("32013", "ZFP"),
    ("32015", "Zstandard"),
    ("32017", "SZ"),
    ("32022", "Granular BitRound"),
    ("32024", "SZ3"),
    ("32026", "Blosc2"),
];

fn refusal(place: &str, error: Error) -> SourceError {
    let unread = |content: String, remedy: &'static str| {
        SourceError::at(place, SourceFault::Unread { content, remedy })
    };
    match error {
        Error::Context { source, .. } => refusal(place, *source),
        Error::Io(error) => SourceError {
            place: Some(place.to_owned()),
            ..error.into()
        },
        Error::UnexpectedEof { .. } | Error::OffsetOutOfBounds(_) => SourceError::damaged(
            place,
            "HDF5's structure refers to bytes beyond the end of the file",
        ),
        Error::ChecksumMismatch { .. } => {
            SourceError::damaged(place, "a checksum differs from its bytes")
        }
        Error::UnsupportedFilter(filter) => {
            let number = filter.trim_start_matches("filter id ");
            let known = FILTERS.iter().find(|(id, _)| *id == number);
            let name = known.map_or("an unknown filter", |(_, name)| *name);
            unread(
                format!("an array compressed with {name} (filter {number})"),
                "write it again with gzip or without compression, as `h5repack -f GZIP=4` does",
            )
        }
        Error::ResourceLimit(_) => unread(
            "a chunk or a header of more than 256 MB".to_owned(),
            "write it again in smaller chunks, as `h5repack -l CHUNK=…` does",
        ),
        Error::Other(text) if text.starts_with("external raw data file") => unread(
            "an array whose numbers are in another file".to_owned(),
            "write it again with the numbers within it, as `h5repack` does",
        ),
        Error::UnsupportedLayoutClass(VIRTUAL) => unread(
            "a virtual dataset with its numbers in other arrays or files".to_owned(),
            "write it again as an array of its own, as `h5repack -l CONTI` does",
        ),
        Error::UnsupportedEncoding(_)
        | Error::UnsupportedSuperblockVersion(_)
        | Error::UnsupportedObjectHeaderVersion(_)
        | Error::UnsupportedBTreeVersion(_)
        | Error::UnsupportedDatatypeClass(_)
        | Error::UnsupportedLayoutClass(_)
        | Error::UnsupportedLayoutVersion(_)
        | Error::UnsupportedFilterPipelineVersion(_)
        | Error::UnsupportedFillValueVersion(_)
        | Error::UnsupportedLinkVersion(_)
        | Error::UnsupportedLinkType(_)
        | Error::UnsupportedChunkIndexType(_) => unread(
            "a part of HDF5 that this reader does not know".to_owned(),
            "write it again with `h5repack`, or from the program that made it as NPY or CSV",
        ),
        _ => contradictory(place),
    }
}
