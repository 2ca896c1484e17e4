//! Storage that recordings are written to: the file system, or in tests a disk that fails.

use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

/// File open for writing. A write may take fewer bytes than it was given, and may be interrupted.
pub trait StoredFile: Write + Seek + Debug + Send {
    /// Cuts or extends the file to `bytes`.
    ///
    /// # Errors
    /// The disk refused.
    fn set_len(&mut self, bytes: u64) -> io::Result<()>;

    /// Returns once the content is on the disk; its name need not be.
    ///
    /// # Errors
    /// The disk refused. It may have dropped what it could not write, and would not report it a second time.
    fn sync_data(&mut self) -> io::Result<()>;
}

/// Operations of a disk that a recording needs.
pub trait Storage: Debug + Send + Sync {
    /// Makes a file; one that exists is an error.
    ///
    /// # Errors
    /// The disk refused.
    fn create_new(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Makes a file, or empties the one that exists.
    ///
    /// # Errors
    /// The disk refused.
    fn create(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Opens a file that exists; whatever is written goes to its end.
    ///
    /// # Errors
    /// The disk refused.
    fn append(&self, path: &Path) -> io::Result<Box<dyn StoredFile>>;

    /// Opens a file to be read.
    ///
    /// # Errors
    /// The disk refused.
    fn read(&self, path: &Path) -> io::Result<Box<dyn Read + Send>>;

    /// Gives the file at `to` the permissions of the file at `of`, if there is one.
    ///
    /// # Errors
    /// The disk refused.
    fn keep_permissions(&self, _of: &Path, _to: &Path) -> io::Result<()> {
        Ok(())
    }

    /// Makes a folder; one that exists is an error.
    ///
    /// # Errors
    /// The disk refused.
    fn create_folder(&self, path: &Path) -> io::Result<()>;

    /// Gives a file another name; a file of that name is replaced.
    ///
    /// # Errors
    /// The disk refused.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// The disk refused.
    fn remove(&self, path: &Path) -> io::Result<()>;

    /// Checks that there is something at `path`.
    ///
    /// # Errors
    /// There is nothing, or the disk refused.
    fn find(&self, path: &Path) -> io::Result<()>;

    /// Returns once the names in a folder are on the disk.
    ///
    /// # Errors
    /// The disk refused.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
}

/// The file system of the computer.
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
        Ok(Box::new(files::open(path)?))
    }

    fn keep_permissions(&self, of: &Path, to: &Path) -> io::Result<()> {
        match fs::metadata(of) {
            Ok(known) if known.is_file() => fs::set_permissions(to, known.permissions()),
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

    /// Does nothing on systems other than Unix, where a folder cannot be opened to be synced.
    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        if cfg!(not(unix)) {
            return Ok(());
        }
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        File::open(path).and_then(|folder| folder.sync_all())
    }
}
