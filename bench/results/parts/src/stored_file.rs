//! Files of parts: complete or absent, also if several processes write them at the same time, and written only if they change.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};

use recording::DiskError;
use recording::disk::{self, OnPath};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::parts_error::PartsError;

/// Extension of a file that is being written.
const TEMPORARY: &str = "tmp";
/// Largest file that is read, bytes.
const LIMIT_BYTES: u64 = 1 << 31;
/// Number of attempts at a file. Another process may remove its temporary file before it is locked, or its folder while it is empty.
const ATTEMPTS: usize = 5;

/// Writes a file in place of an older one, with its folder. Another process may write it at the same time: one of both remains.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), DiskError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut result = write_once(path, bytes);
    for _ in 1..ATTEMPTS {
        match &result {
            Err(error) if error.source.kind() == io::ErrorKind::NotFound => {
                result = write_once(path, bytes);
            }
            _ => break,
        }
    }
    result?;
    disk::sync_folder(folder)
}

fn write_once(path: &Path, bytes: &[u8]) -> Result<(), DiskError> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).with_path("create", folder)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}-{number}.{TEMPORARY}", process::id()));
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&temporary)
        .with_path("create", &temporary)?;
    // A file without a lock is that of a process that has ended. Where a file system has no locks, nothing is cleaned.
    let _ = file.lock();
    let result = file
        .write_all(bytes)
        .and_then(|()| file.sync_data())
        .with_path("write", &temporary)
        .and_then(|()| fs::rename(&temporary, path).with_path("replace", path));
    if result.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    result
}

/// Removes the temporary files that ended processes left in a folder and the folders in it.
pub(crate) fn clean(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            clean(&path);
        } else if is_temporary(&path) && File::open(&path).is_ok_and(|file| file.try_lock().is_ok())
        {
            // Another process may have removed it.
            let _ = fs::remove_file(&path);
        }
    }
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().map(OsStr::to_string_lossy);
    name.is_some_and(|name| name.starts_with('.') && name.ends_with(TEMPORARY))
}

/// Writes a value, unless the file has it.
pub(crate) fn write_value(path: &Path, value: &impl Serialize) -> Result<(), PartsError> {
    let bytes = encode(value).map_err(|reason| PartsError::Encode {
        path: path.to_owned(),
        reason,
    })?;
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    Ok(write(path, &bytes)?)
}

/// Reads a value; `None` without a file.
pub(crate) fn read_value<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, PartsError> {
    let file = match bounded_files::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_path("read", path)?,
    };
    let bytes = bounded_files::read_limited(file, LIMIT_BYTES).with_path("read", path)?;
    decode(&bytes)
        .map(Some)
        .map_err(|reason| PartsError::damaged(path, reason))
}

/// Returns the names in a folder as paths, sorted; none if it does not exist.
pub(crate) fn paths(folder: &Path) -> Result<Vec<PathBuf>, DiskError> {
    let names = disk::entries(folder)?;
    let visible = names.iter().filter(|name| !name.starts_with('.'));
    Ok(visible.map(|name| folder.join(name)).collect())
}

/// Returns a value as bytes, from which [`decode`] makes the same value, each number by its bits.
pub(crate) fn encode(value: &impl Serialize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    match ciborium::into_writer(value, &mut bytes) {
        Ok(()) => Ok(bytes),
        Err(ciborium::ser::Error::Value(reason)) => Err(reason),
        Err(ciborium::ser::Error::Io(error)) => Err(error.to_string()),
    }
}

/// Returns the value that [`encode`] wrote, or the fault of its bytes.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, &'static str> {
    let mut rest = bytes;
    match ciborium::from_reader(&mut rest) {
        Ok(value) if rest.is_empty() => Ok(value),
        Ok(_) => Err("it has more bytes than its content"),
        Err(ciborium::de::Error::Io(_)) => Err("it is cut off"),
        Err(_) => Err("its content is not that of this version"),
    }
}
