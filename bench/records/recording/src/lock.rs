//! Lock files, which one process at a time can hold and which contain its process number.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::DiskError;
use crate::disk::OnPath;
use crate::disk_limit::{self, DiskLimit, cannot_lock};

/// Outcome of trying to take a lock.
///
/// A disk without file locks has an owner's mark in their place.
#[derive(Debug)]
pub enum Lock {
    /// The lock is held until it is dropped.
    Taken(HeldLock),
    /// Another process holds the lock.
    Held {
        /// Number of that process, if the file contains it.
        holder: Option<u32>,
        /// Owner mark that says so, if the disk has no locks.
        mark: Option<PathBuf>,
    },
}

/// Lock of this process.
#[derive(Debug)]
pub struct HeldLock {
    /// The operating system releases the lock when the file is closed or the process ends for any reason.
    _file: File,
    _mark: Option<OwnerMark>,
}

/// File that marks its folder as in use, on a disk without locks: creating it fails if it exists, also across a network. It is
/// removed when dropped, but stays if the process is killed; only the user can know whether its owner still runs on
/// another computer.
#[derive(Debug)]
struct OwnerMark(PathBuf);

impl Drop for OwnerMark {
    fn drop(&mut self) {
        // One that cannot be removed keeps others out, which is safe.
        let _ = fs::remove_file(&self.0);
    }
}

impl Lock {
    /// Tries to take the lock on the file at `path`, which is created if missing. A symbolic link is refused.
    ///
    /// # Errors
    /// The file cannot be created, locked or written.
    pub fn try_take(path: &Path) -> Result<Self, DiskError> {
        let mut file = bounded_files::open_in_place(path).with_path("open", path)?;
        let mark = match file.try_lock() {
            Ok(()) => None,
            Err(TryLockError::WouldBlock) => {
                return Ok(Self::Held {
                    holder: process_number(&mut file),
                    mark: None,
                });
            }
            Err(TryLockError::Error(error)) if cannot_lock(&error) => {
                disk_limit::note(DiskLimit::Locks, path.parent().unwrap_or(path));
                match OwnerMark::try_create(path)? {
                    Ok(mark) => Some(mark),
                    Err(held) => return Ok(held),
                }
            }
            Err(TryLockError::Error(error)) => return Err(error).with_path("lock", path)?,
        };
        file.set_len(0)
            .and_then(|()| writeln!(file, "{}", std::process::id()))
            .with_path("write", path)?;
        Ok(Self::Taken(HeldLock {
            _file: file,
            _mark: mark,
        }))
    }
}

impl OwnerMark {
    /// Creates the mark of the lock file at `lock`; returns [`Lock::Held`] if it exists.
    fn try_create(lock: &Path) -> Result<Result<Self, Lock>, DiskError> {
        let mut name = lock.file_name().map_or_else(OsString::new, OsString::from);
        name.push(".owner");
        let path = lock.with_file_name(name);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                let mark = Self(path);
                let written = writeln!(file, "{}", std::process::id());
                written
                    .and_then(|()| file.sync_all())
                    .with_path("write", &mark.0)?;
                Ok(Ok(mark))
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                let holder = bounded_files::open(&path)
                    .ok()
                    .and_then(|mut file| process_number(&mut file));
                Ok(Err(Lock::Held {
                    holder,
                    mark: Some(path),
                }))
            }
            Err(error) => Err(error).with_path("create", &path)?,
        }
    }
}

/// Returns the process number at the start of a file.
fn process_number(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.take(32).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Returns the holder of a lock as the end of a sentence, such as ` (process 17)`; empty if unknown.
pub fn holder(pid: Option<u32>) -> String {
    pid.map(|pid| format!(" (process {pid})"))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_owner_mark_keeps_a_second_owner_out_until_the_first_has_ended() {
        let folder = tempfile::tempdir().unwrap();
        let lock = folder.path().join(".lock");
        let first = OwnerMark::try_create(&lock).unwrap().unwrap();
        let second = OwnerMark::try_create(&lock).unwrap();
        let Err(Lock::Held { holder, mark }) = second else {
            panic!("{second:?}");
        };
        assert_eq!(holder, Some(std::process::id()));
        assert_eq!(mark, Some(folder.path().join(".lock.owner")));
        drop(first);
        assert!(OwnerMark::try_create(&lock).unwrap().is_ok());
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }
}
