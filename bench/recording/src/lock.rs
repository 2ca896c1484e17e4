//! Files that one process at a time may hold, with its number in them for whoever comes second.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;

use crate::DiskError;
use crate::disk::OnPath;

/// What became of asking for a lock.
#[derive(Debug)]
pub enum Lock {
    /// Held for as long as the file lives; the operating system releases it when this process ends, however it ends.
    Taken(File),
    /// Another has it.
    Held {
        /// Its process, if it left its number.
        by: Option<u32>,
    },
}

impl Lock {
    /// Asks for the lock on the file at `path`, which is made if it is not there.
    ///
    /// # Errors
    /// The file cannot be made, locked or written.
    pub fn ask(path: &Path) -> Result<Self, DiskError> {
        let mut file = open(path).on("open", path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                let by = file.read_to_string(&mut text).ok();
                return Ok(Self::Held {
                    by: by.and_then(|_| text.trim().parse().ok()),
                });
            }
            Err(TryLockError::Error(error)) => return Err(error).on("lock", path)?,
        }
        file.set_len(0)
            .and_then(|()| writeln!(file, "{}", std::process::id()))
            .on("write", path)?;
        Ok(Self::Taken(file))
    }
}

/// One that is there is not asked to be made: in a folder of temporary files that is refused for another user's.
fn open(path: &Path) -> std::io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => options.create(true).open(path),
        opened => opened,
    }
}

/// Who holds it, for the end of a sentence.
pub fn holder(by: Option<u32>) -> String {
    by.map(|pid| format!(" (process {pid})"))
        .unwrap_or_default()
}
