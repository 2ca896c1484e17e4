//! Files that report data as saved only when they are on disk: no hidden buffer, no ignored error.

use std::ffi::OsString;
use std::fs;
use std::io::{self, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::storage::{FileSystem, Storage, StoredFile};

/// Bytes buffered before a write.
const BATCH_BYTES: usize = 1 << 18;

/// Failure of a file operation.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}: {}", path.display(), bounded_files::cause(source))]
pub struct DiskError {
    /// Attempted operation, such as `write`.
    pub action: &'static str,
    /// The file or folder.
    pub path: PathBuf,
    /// Reason given by the operating system.
    pub source: io::Error,
}

/// Extension that adds action and path to the error of an operation.
pub trait OnPath<T> {
    /// Adds `action` and `path` to the error.
    ///
    /// # Errors
    /// The error of the operation.
    fn with_path(self, action: &'static str, path: &Path) -> Result<T, DiskError>;
}

impl<T> OnPath<T> for io::Result<T> {
    fn with_path(self, action: &'static str, path: &Path) -> Result<T, DiskError> {
        self.map_err(|source| DiskError {
            action,
            path: path.to_owned(),
            source,
        })
    }
}

/// Kind of the records in a file, which is cut only between records.
#[derive(Debug, Clone, Copy)]
pub enum Records {
    /// Records of a fixed number of bytes.
    Bytes(usize),
    /// Lines.
    Lines,
}

impl Records {
    /// Returns the length of the complete records in `bytes`, which starts at the beginning of a record.
    fn complete_bytes(self, bytes: &[u8]) -> usize {
        match self {
            Self::Bytes(size) => bytes.len() / size * size,
            Self::Lines => bytes
                .iter()
                .rposition(|b| *b == b'\n')
                .map_or(0, |index| index + 1),
        }
    }
}

/// New file, extended by complete records.
#[derive(Debug)]
pub struct AppendFile {
    path: PathBuf,
    storage: Arc<dyn Storage>,
    file: Box<dyn StoredFile>,
    records: Records,
    /// Complete records not yet written to the file.
    pending: Vec<u8>,
    /// Length of the head and the complete records in the file.
    valid_bytes: u64,
    failure: Option<FailureKind>,
}

/// Failure that blocks further writes until the file is salvaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FailureKind {
    /// A write failed; `valid_bytes` is still the length of the valid content.
    Write,
    /// A sync failed; the system may have dropped unwritten data, and would not report this a second time.
    Sync,
}

impl AppendFile {
    /// Creates the file with `head` at its start; fails if the file exists.
    pub fn create(
        storage: &Arc<dyn Storage>,
        path: PathBuf,
        head: &[u8],
        records: Records,
    ) -> Result<Self, DiskError> {
        let mut file = storage.create_new(&path).with_path("create", &path)?;
        file.write_all(head).with_path("write", &path)?;
        Ok(Self {
            path,
            storage: Arc::clone(storage),
            file,
            records,
            pending: Vec::with_capacity(BATCH_BYTES + BATCH_BYTES / 4),
            valid_bytes: head.len() as u64,
            failure: None,
        })
    }

    /// Appends complete records through `write`.
    pub fn append(&mut self, write: impl FnOnce(&mut Vec<u8>)) -> Result<(), DiskError> {
        write(&mut self.pending);
        if self.pending.len() >= BATCH_BYTES {
            self.write_pending()?;
        }
        Ok(())
    }

    /// Writes all pending records to the file.
    fn write_pending(&mut self) -> Result<(), DiskError> {
        if self.failure.is_some() {
            return Err(io::Error::other("an earlier write failed")).with_path("write", &self.path);
        }
        let mut n_written = 0;
        let result = loop {
            if n_written == self.pending.len() {
                break Ok(());
            }
            match self.file.write(&self.pending[n_written..]) {
                Ok(0) => break Err(io::ErrorKind::WriteZero.into()),
                Ok(bytes) => n_written += bytes,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => break Err(error),
            }
        };
        self.valid_bytes += self.records.complete_bytes(&self.pending[..n_written]) as u64;
        self.pending.clear();
        if result.is_err() {
            self.failure = Some(FailureKind::Write);
        }
        result.with_path("write", &self.path)
    }

    /// Returns the number of bytes appended, whether on disk or not.
    pub fn bytes(&self) -> u64 {
        self.valid_bytes + self.pending.len() as u64
    }

    /// Writes the pending records, then overwrites the head.
    pub fn set_head(&mut self, head: &[u8]) -> Result<(), DiskError> {
        self.write_pending()?;
        self.overwrite_head(head)
    }

    fn overwrite_head(&mut self, head: &[u8]) -> Result<(), DiskError> {
        let result = self
            .file
            .seek(SeekFrom::Start(0))
            .and_then(|_| self.file.write_all(head))
            .and_then(|()| self.file.seek(SeekFrom::Start(self.valid_bytes)));
        if result.is_err() {
            // The next write would go to an arbitrary position.
            self.failure = Some(FailureKind::Write);
        }
        result.map(drop).with_path("write", &self.path)
    }

    /// Returns once all appended data are on disk under the file's name.
    pub fn sync(&mut self) -> Result<(), DiskError> {
        self.write_pending()?;
        let result = self.file.sync_data();
        if result.is_err() {
            self.failure = Some(FailureKind::Sync);
        }
        result.with_path("sync", &self.path)?;
        // Syncing an unlinked file succeeds.
        self.storage.find(&self.path).with_path("find", &self.path)
    }

    /// Saves as much as possible after a failure, in this file or another one of the recording: writes the pending
    /// records, cuts the file to complete records and replaces the head with the result of `head` for their length in
    /// bytes. Returns the number of bytes kept.
    pub fn salvage(&mut self, head: impl FnOnce(u64) -> Vec<u8>) -> Result<u64, DiskError> {
        // `valid_bytes` includes all successful writes.
        let _ = self.write_pending();
        if self.failure == Some(FailureKind::Sync) {
            return Err(io::Error::other("an earlier sync failed")).with_path("sync", &self.path);
        }
        self.file
            .set_len(self.valid_bytes)
            .with_path("cut", &self.path)?;
        self.overwrite_head(&head(self.valid_bytes))?;
        self.failure = None;
        self.sync()?;
        Ok(self.valid_bytes)
    }
}

/// Replaces the content of the file at `path` with `contents`; at every moment either the old or the new content is
/// complete. An existing file keeps its permissions.
pub fn replace_file(path: &Path, contents: &[u8]) -> Result<(), DiskError> {
    replace_file_on(&FileSystem, path, contents)
}

/// Does the same as [`replace_file`], on any storage.
pub fn replace_file_on(
    storage: &dyn Storage,
    path: &Path,
    contents: &[u8],
) -> Result<(), DiskError> {
    replace_file_by(storage, path, |file| file.write_all(contents))
}

/// Does the same as [`replace_file_on`], with contents that `write` writes piece by piece.
pub fn replace_file_by(
    storage: &dyn Storage,
    path: &Path,
    write: impl FnOnce(&mut dyn StoredFile) -> io::Result<()>,
) -> Result<(), DiskError> {
    let mut name = path.file_name().map_or_else(OsString::new, OsString::from);
    name.push(".tmp");
    let temporary = path.with_file_name(name);
    // A killed process may have left a temporary file.
    let result = storage
        .create(&temporary)
        .with_path("create", &temporary)
        .and_then(|mut file| {
            storage
                .keep_permissions(path, &temporary)
                .with_path("create", &temporary)?;
            write(&mut *file).with_path("write", &temporary)?;
            file.sync_data().with_path("sync", &temporary)
        })
        .and_then(|()| storage.rename(&temporary, path).with_path("replace", path));
    if result.is_err() {
        // The old file is still complete; a leftover of the new one must not block the next attempt.
        let _ = storage.remove(&temporary);
    }
    result?;
    sync_parent(storage, path)
}

/// Returns whether `path` exists; fails if this cannot be determined.
pub fn exists(storage: &dyn Storage, path: &Path) -> Result<bool, DiskError> {
    match storage.find(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_path("find", path),
    }
}

/// Returns the content of a file of at most `limit_bytes`.
pub fn read_on(storage: &dyn Storage, path: &Path, limit_bytes: u64) -> Result<Vec<u8>, DiskError> {
    let file = storage.read(path);
    file.and_then(|file| bounded_files::read_limited(file, limit_bytes))
        .with_path("read", path)
}

/// Creates an empty file and returns once its name is on disk; fails if the file exists.
pub fn create_empty(storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
    storage.create_new(path).with_path("create", path)?;
    sync_parent(storage, path)
}

/// Makes the name of `path` durable.
pub fn sync_parent(storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
    path.parent().map_or(Ok(()), |folder| {
        storage.sync_folder(folder).with_path("sync", folder)
    })
}

/// Makes the names in a folder durable. Does nothing on systems other than Unix, where a folder cannot be opened for
/// syncing.
pub fn sync_folder(path: &Path) -> Result<(), DiskError> {
    FileSystem.sync_folder(path).with_path("sync", path)
}

/// Returns whether `target`, which need not exist, is `folder` or lies in it.
#[must_use]
pub fn is_within(target: &Path, folder: &Path) -> bool {
    let Ok(folder) = folder.canonicalize() else {
        return false;
    };
    // Nor need the folders above it exist.
    let absolute = std::path::absolute(target).unwrap_or_else(|_| target.to_owned());
    let mut existing = absolute
        .ancestors()
        .filter_map(|path| path.canonicalize().ok());
    existing
        .next()
        .is_some_and(|existing| existing.starts_with(&folder))
}

/// Returns the sorted names in a folder; an empty list if the folder does not exist. Names that are not Unicode get
/// replacement characters.
pub fn entries(folder: &Path) -> Result<Vec<String>, DiskError> {
    let listing = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        listing => listing.with_path("list", folder)?,
    };
    let mut names = Vec::new();
    for entry in listing {
        names.push(
            entry
                .with_path("list", folder)?
                .file_name()
                .to_string_lossy()
                .into_owned(),
        );
    }
    names.sort_unstable();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{File, OpenOptions};

    fn file_system() -> Arc<dyn Storage> {
        Arc::new(FileSystem)
    }

    #[cfg(target_os = "linux")]
    fn lines_to(device: &str) -> AppendFile {
        let path = PathBuf::from(device);
        let file = OpenOptions::new().write(true).open(&path).unwrap();
        AppendFile {
            path,
            storage: file_system(),
            file: Box::new(file),
            records: Records::Lines,
            pending: Vec::new(),
            valid_bytes: 0,
            failure: None,
        }
    }

    /// Faults 25, 26.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_said_to_be_full() {
        let mut full = lines_to("/dev/full");
        full.append(|bytes| bytes.extend(b"1,2\n")).unwrap();
        let error = full.sync().unwrap_err();
        assert!(error.to_string().contains("the disk is full"), "{error}");
        assert_eq!(error.action, "write");
        // No records are pending any longer, but the data are not saved.
        assert!(full.sync().is_err());
    }

    /// Fault 26.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_could_not_be_synced_is_never_called_saved() {
        // `/dev/null` accepts every byte but cannot be synced.
        let mut rows = lines_to("/dev/null");
        rows.append(|bytes| bytes.extend(b"1\n")).unwrap();
        assert_eq!(rows.sync().unwrap_err().action, "sync");
        assert_eq!(rows.failure, Some(FailureKind::Sync));
        // A second sync could succeed after the system dropped unwritten data.
        let folder = tempfile::tempdir().unwrap();
        rows.file = Box::new(File::create_new(folder.path().join("a")).unwrap());
        assert!(rows.sync().is_err());
        assert_eq!(rows.salvage(|_| Vec::new()).unwrap_err().action, "sync");
    }

    /// Fault 26.
    #[test]
    fn a_removed_file_is_not_saved() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let mut file =
            AppendFile::create(&file_system(), path.clone(), b"", Records::Lines).unwrap();
        file.append(|bytes| bytes.extend(b"1\n")).unwrap();
        file.sync().unwrap();
        fs::remove_file(&path).unwrap();
        file.append(|bytes| bytes.extend(b"2\n")).unwrap();
        assert_eq!(file.sync().unwrap_err().action, "find");
    }

    #[test]
    fn replacing_leaves_one_complete_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        for text in ["first", "second"] {
            replace_file(&path, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_replacement_leaves_the_old_file_and_can_be_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        replace_file(&path, b"old").unwrap();
        // A folder blocks the temporary file.
        fs::create_dir(folder.path().join("a.toml.tmp")).unwrap();
        assert!(replace_file(&path, b"new").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        fs::remove_dir(folder.path().join("a.toml.tmp")).unwrap();
        replace_file(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn records_are_cut_between_records() {
        assert_eq!(Records::Bytes(8).complete_bytes(&[0; 23]), 16);
        assert_eq!(Records::Lines.complete_bytes(b"1,2\n3,"), 4);
        assert_eq!(Records::Lines.complete_bytes(b"1,2"), 0);
    }
}
