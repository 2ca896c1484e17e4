//! SHA-256 of the files of a recording, read back in small steps.
//!
//! The sums cannot be computed while writing: the header of `signals.wav` is rewritten until the recording ends, and
//! SHA-256 begins with it. Reading back also proves that the saved files can be read.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::disk::{DiskError, OnPath};
use crate::storage::Storage;
use crate::{FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE};

/// Files of a recording, in the order of summing.
pub const FILES: [&str; 4] = [MANIFEST_FILE, FORCE_FILE, POSITION_FILE, SIGNALS_FILE];

/// Bytes per read.
const BUFFER_BYTES: usize = 1 << 16;

/// SHA-256 of each file of a recording, in hexadecimal, by the file's name.
pub type Sums = BTreeMap<String, String>;

/// File being read, with its sum so far.
struct OpenFile {
    name: &'static str,
    path: PathBuf,
    source: Box<dyn Read + Send>,
    digest: Sha256,
}

/// SHA-256 computation of a recording in progress.
pub struct Summation {
    storage: Arc<dyn Storage>,
    folder: PathBuf,
    pending_files: VecDeque<&'static str>,
    open_file: Option<OpenFile>,
    sums: Sums,
    buffer: Vec<u8>,
}

impl Summation {
    /// Creates a computation that has read no data yet.
    #[must_use]
    pub fn new(storage: Arc<dyn Storage>, folder: &Path) -> Self {
        Self {
            storage,
            folder: folder.to_owned(),
            pending_files: FILES.into(),
            open_file: None,
            sums: Sums::new(),
            buffer: vec![0; BUFFER_BYTES],
        }
    }

    /// Returns the recording.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Reads about `bytes` more bytes; returns the number of bytes read, which is smaller only at the end of all files.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn advance(&mut self, bytes: usize) -> Result<usize, DiskError> {
        let mut n_read = 0;
        while n_read < bytes {
            self.open_next()?;
            let Some(file) = &mut self.open_file else {
                break;
            };
            match file.source.read(&mut self.buffer) {
                Ok(0) => {
                    if let Some(file) = self.open_file.take() {
                        let sum = hex_text(&file.digest.finalize());
                        self.sums.insert(file.name.to_owned(), sum);
                    }
                }
                Ok(n) => {
                    file.digest.update(&self.buffer[..n]);
                    n_read += n;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error).with_path("read back", &file.path),
            }
        }
        Ok(n_read)
    }

    /// Opens the next file, if no file is open and one is left.
    fn open_next(&mut self) -> Result<(), DiskError> {
        if self.open_file.is_none()
            && let Some(name) = self.pending_files.pop_front()
        {
            let path = self.folder.join(name);
            self.open_file = Some(OpenFile {
                name,
                source: self.storage.read(&path).with_path("read back", &path)?,
                path,
                digest: Sha256::new(),
            });
        }
        Ok(())
    }

    /// Returns the sums once every file has been read.
    #[must_use]
    pub fn sums(&self) -> Option<&Sums> {
        (self.open_file.is_none() && self.pending_files.is_empty()).then_some(&self.sums)
    }
}

/// Returns the length of a file in bytes, and its SHA-256.
///
/// # Errors
/// The file cannot be read.
pub fn file_sum(path: &Path) -> io::Result<(u64, String)> {
    let mut source = bounded_files::open(path)?;
    let (mut digest, mut bytes) = (Sha256::new(), 0);
    let mut buffer = vec![0; 4 * BUFFER_BYTES];
    loop {
        match source.read(&mut buffer) {
            Ok(0) => return Ok((bytes, hex_text(&digest.finalize()))),
            Ok(n) => {
                digest.update(&buffer[..n]);
                bytes += n as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Returns the SHA-256 of a text file with the line ends of the recorder, which are LF, and without a byte order mark.
///
/// # Errors
/// The file cannot be read.
pub fn text_sum(path: &Path) -> io::Result<String> {
    let mut source = BufReader::with_capacity(BUFFER_BYTES, bounded_files::open(path)?);
    let mut digest = Sha256::new();
    let mut text = Vec::with_capacity(BUFFER_BYTES);
    let (mut is_at_start, mut ends_with_cr) = (true, false);
    loop {
        let bytes = source.fill_buf()?;
        if bytes.is_empty() {
            return Ok(hex_text(&digest.finalize()));
        }
        let n_read = bytes.len();
        let content = bytes
            .strip_prefix("\u{feff}".as_bytes())
            .filter(|_| is_at_start)
            .unwrap_or(bytes);
        text.clear();
        for &byte in content {
            match byte {
                b'\n' if ends_with_cr => {}
                b'\r' => text.push(b'\n'),
                byte => text.push(byte),
            }
            ends_with_cr = byte == b'\r';
        }
        digest.update(&text);
        source.consume(n_read);
        is_at_start = false;
    }
}

impl std::fmt::Debug for Summation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Summation")
            .field("folder", &self.folder)
            .field("done", &self.sums)
            .finish_non_exhaustive()
    }
}

fn hex_text(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::FileSystem;
    use std::fs;

    /// NIST's example (FIPS 180-4): "abc".
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    const EMPTY: &str = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

    #[test]
    fn sums_match_the_standard_for_any_read_size() {
        let folder = tempfile::tempdir().unwrap();
        for name in FILES {
            fs::write(folder.path().join(name), "abc").unwrap();
        }
        fs::write(folder.path().join(FORCE_FILE), "").unwrap();
        let mut summing = Summation::new(Arc::new(FileSystem), folder.path());
        let mut steps = 0;
        while summing.sums().is_none() {
            summing.advance(1).unwrap();
            steps += 1;
        }
        assert!(steps >= 3, "{steps} steps for three files with a content");
        let sums = summing.sums().unwrap();
        assert_eq!(sums.len(), FILES.len());
        assert_eq!(sums[SIGNALS_FILE], ABC);
        assert_eq!(sums[FORCE_FILE], EMPTY);
        let path = folder.path().join(SIGNALS_FILE);
        assert_eq!(file_sum(&path).unwrap(), (3, ABC.to_owned()));
    }

    #[test]
    fn line_ends_and_a_byte_order_mark_do_not_change_the_sum_of_a_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FORCE_FILE);
        let lines: Vec<String> = (0..20_000).map(|i| format!("{i},0.5")).collect();
        let sum = |end: &str, mark: &str| {
            fs::write(&path, format!("{mark}{}{end}", lines.join(end))).unwrap();
            text_sum(&path).unwrap()
        };
        let recorded_sum = sum("\n", "");
        for end in ["\n", "\r\n", "\r"] {
            assert_eq!(sum(end, ""), recorded_sum);
            assert_eq!(sum(end, "\u{feff}"), recorded_sum);
        }
        assert_ne!(sum("\n\n", ""), recorded_sum);
        fs::write(&path, "abc").unwrap();
        assert_eq!(text_sum(&path).unwrap(), ABC);
    }

    #[test]
    fn a_missing_file_has_no_sum() {
        let folder = tempfile::tempdir().unwrap();
        let mut summing = Summation::new(Arc::new(FileSystem), folder.path());
        assert_eq!(summing.advance(1).unwrap_err().action, "read back");
    }
}
