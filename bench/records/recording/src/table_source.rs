//! Bytes of a table: those of its file, or those that gzip compressed in an archive.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

/// Extension of a compressed table.
const COMPRESSED: &str = "gz";

/// Returns the path of a table in the folder of a recording: compressed by gzip only if there is no plain one.
#[must_use]
pub fn table_path(folder: &Path, file: &str) -> PathBuf {
    let plain = folder.join(file);
    let compressed = folder.join(format!("{file}.{COMPRESSED}"));
    match !plain.exists() && compressed.exists() {
        true => compressed,
        false => plain,
    }
}

/// Bytes of a table.
#[derive(Debug)]
pub(crate) enum TableSource {
    Plain(File),
    Compressed(MultiGzDecoder<File>),
}

impl TableSource {
    /// Reads the open file of a table, compressed if the name at `path` ends so.
    pub(crate) fn new(path: &Path, file: File) -> Self {
        match path.extension().is_some_and(|end| end == COMPRESSED) {
            true => Self::Compressed(MultiGzDecoder::new(file)),
            false => Self::Plain(file),
        }
    }
}

impl Read for TableSource {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(buffer),
            Self::Compressed(decoder) => decoder.read(buffer).map_err(|error| match error.kind() {
                ErrorKind::InvalidData | ErrorKind::InvalidInput | ErrorKind::UnexpectedEof => {
                    io::Error::new(
                        ErrorKind::InvalidData,
                        "gzip cannot unpack it: it is damaged or copied in part; copy it again",
                    )
                }
                _ => error,
            }),
        }
    }
}
