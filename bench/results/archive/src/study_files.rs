//! Copies of files that an archive has unchanged.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use recording::disk::{OnPath, entries};
use recording::sums::file_sum;

use crate::archive_error::ArchiveError;

/// Extension of a file or folder that is being written.
pub(crate) const PARTIAL: &str = "partial";

/// Copies the files of a folder, without those in its folders and without hidden ones; an equal copy is left as it is.
///
/// # Errors
/// A file cannot be read or written.
pub(crate) fn copy_files(
    source: &Path,
    target: &Path,
    is_copied: impl Fn(&str) -> bool,
) -> Result<(), ArchiveError> {
    fs::create_dir_all(target).with_path("create", target)?;
    for name in entries(source)? {
        let from = source.join(&name);
        if !name.starts_with('.') && from.is_file() && is_copied(&name) {
            copy(&from, &target.join(&name))?;
        }
    }
    Ok(())
}

/// Copies a file, complete or not at all; an equal copy is left as it is.
fn copy(source: &Path, target: &Path) -> Result<(), ArchiveError> {
    if target.exists() && is_same(source, target)? {
        return Ok(());
    }
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let temporary = target.with_file_name(format!(".{name}.{PARTIAL}"));
    let write = || -> io::Result<()> {
        let mut from = bounded_files::open(source)?;
        let mut to = File::create(&temporary)?;
        io::copy(&mut from, &mut to)?;
        to.sync_data()
    };
    let result = write().with_path("copy", source);
    let result = result.and_then(|()| fs::rename(&temporary, target).with_path("replace", target));
    if result.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    Ok(result?)
}

/// Returns whether two files have the same content.
pub(crate) fn is_same(first: &Path, second: &Path) -> Result<bool, ArchiveError> {
    let length = |path: &Path| fs::metadata(path).map(|metadata| metadata.len());
    if length(first).with_path("read", first)? != length(second).with_path("read", second)? {
        return Ok(false);
    }
    let sum = |path: &Path| file_sum(path).with_path("read", path);
    Ok(sum(first)? == sum(second)?)
}
