//! Storage for recordings: the file system, or in tests a disk that fails.

use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use crate::disk_limit::{self, DiskLimit, cannot_sync_folder};

/// File open for writing. A write may be partial or interrupted.
pub trait StoredFile: Write + Seek + Debug + Send {
    /// Cuts or extends the file to `bytes`.
    ///
    /// # Errors
    /// The disk refused.
    fn set_len(&mut self, bytes: u64) -> io::Result<()>;

    /// Returns once the content is on disk; the file's name may not be.
    ///
    /// # Errors
    /// The disk refused. It may have dropped unwritten data, and would not report this a second time.
    fn sync_data(&mut self) -> io::Result<()>;
}

/// Disk operations for recordings.
pub trait Storage: Debug + Send + Sync {
    /// Creates a file; fails if the file exists.
    ///
    /// # Errors
    /// The disk refused.
    fn create_new(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Creates a file, or truncates an existing one.
    ///
    /// # Errors
    /// The disk refused.
    fn create(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Opens an existing file for appending.
    ///
    /// # Errors
    /// The disk refused.
    fn append(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Opens a file for reading.
    ///
    /// # Errors
    /// The disk refused.
    fn read(&self, path: &Path) -> io::Result<Box<dyn Read + Send>>;

    /// Gives the file at `target` the permissions of the file at `source`, if it exists.
    ///
    /// # Errors
    /// The disk refused.
    fn keep_permissions(&self, _source: &Path, _target: &Path) -> io::Result<()> {
        Ok(())
    }

    /// Creates a folder; fails if the folder exists.
    ///
    /// # Errors
    /// The disk refused.
    fn create_folder(&self, path: &Path) -> io::Result<()>;

    /// Renames a file, replacing an existing file.
    ///
    /// # Errors
    /// The disk refused.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// The disk refused.
    fn remove(&self, path: &Path) -> io::Result<()>;

    /// Checks that `path` exists.
    ///
    /// # Errors
    /// The path does not exist, or the disk refused.
    fn find(&self, path: &Path) -> io::Result<()>;

    /// Returns once the names in a folder are on disk.
    ///
    /// # Errors
    /// The disk refused.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
}

/// File system of the computer.
#[derive(Debug, Clone, Copy, Default)]
pub struct FileSystem;

impl StoredFile for File {
    fn set_len(&mut self, bytes: u64) -> io::Result<()> {
        Self::set_len(self, bytes)
    }

    fn sync_data(&mut self) -> io::Result<()> {
        Self::sync_data(self)
    }
}

impl Storage for FileSystem {
    fn create_new(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        Ok(Box::new(File::create_new(path)?))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        Ok(Box::new(File::create(path)?))
    }

    fn append(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        Ok(Box::new(OpenOptions::new().append(true).open(path)?))
    }

    fn read(&self, path: &Path) -> io::Result<Box<dyn Read + Send>> {
        Ok(Box::new(bounded_files::open(path)?))
    }

    fn keep_permissions(&self, source: &Path, target: &Path) -> io::Result<()> {
        match fs::metadata(source) {
            // A disk without rights refuses to set them, and shows all files alike.
            Ok(metadata) if metadata.is_file() => {
                let permissions = metadata.permissions();
                if fs::metadata(target)?.permissions() == permissions {
                    return Ok(());
                }
                fs::set_permissions(target, permissions)
            }
            _ => Ok(()),
        }
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        fs::create_dir(path)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn find(&self, path: &Path) -> io::Result<()> {
        fs::metadata(path).map(drop)
    }

    /// Does nothing on systems other than Unix, where a folder cannot be opened for syncing; a disk that cannot sync folders is
    /// noted as [`DiskLimit::FolderSync`].
    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        if cfg!(not(unix)) {
            return Ok(());
        }
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        match File::open(path).and_then(|folder| folder.sync_all()) {
            Err(error) if cannot_sync_folder(&error) => {
                disk_limit::note(DiskLimit::FolderSync, path);
                Ok(())
            }
            result => result,
        }
    }
}
