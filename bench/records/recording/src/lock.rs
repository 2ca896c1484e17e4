//! Lock files, which one process at a time can hold and which contain its process number.

use std::fs::{File, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

use crate::DiskError;
use crate::disk::OnPath;

/// Outcome of trying to take a lock.
///
/// On platforms without file locks, such as WebAssembly, every attempt fails with an error that names the reason.
#[derive(Debug)]
pub enum Lock {
    /// The lock is held until the file is dropped; the operating system releases it when the process ends for any reason.
    Taken(File),
    /// Another process holds the lock.
    Held {
        /// Number of that process, if the file contains it.
        holder: Option<u32>,
    },
}

impl Lock {
    /// Tries to take the lock on the file at `path`, which is created if missing. A symbolic link is refused.
    ///
    /// # Errors
    /// The file cannot be created, locked or written.
    pub fn try_take(path: &Path) -> Result<Self, DiskError> {
        let mut file = bounded_files::open_in_place(path).with_path("open", path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                let n_read = (&mut file).take(32).read_to_string(&mut text).ok();
                return Ok(Self::Held {
                    holder: n_read.and_then(|_| text.trim().parse().ok()),
                });
            }
            Err(TryLockError::Error(error)) => return Err(error).with_path("lock", path)?,
        }
        file.set_len(0)
            .and_then(|()| writeln!(file, "{}", std::process::id()))
            .with_path("write", path)?;
        Ok(Self::Taken(file))
    }
}

/// Returns the holder of a lock as the end of a sentence, such as ` (process 17)`; empty if unknown.
pub fn holder(pid: Option<u32>) -> String {
    pid.map(|pid| format!(" (process {pid})"))
        .unwrap_or_default()
}
