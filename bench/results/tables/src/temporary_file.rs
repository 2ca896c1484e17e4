//! A file under a temporary name until it is complete.

use std::fs::File;
use std::path::{Path, PathBuf};

use recording::DiskError;
use recording::disk::OnPath;
use recording::storage::{FileSystem, Storage};

/// File under a temporary name, which is removed if it does not replace the file of its own name.
pub(crate) struct TemporaryFile {
    path: PathBuf,
    temporary: PathBuf,
}

impl TemporaryFile {
    /// Creates the file that becomes `path`, with the permissions of an existing one.
    ///
    /// # Errors
    /// The operating system refused.
    pub(crate) fn create(path: PathBuf) -> Result<(Self, File), DiskError> {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".tmp");
        let temporary = path.with_file_name(name);
        let handle = File::create(&temporary).with_path("create", &temporary)?;
        let file = Self { path, temporary };
        FileSystem
            .keep_permissions(&file.path, &file.temporary)
            .with_path("create", &file.temporary)?;
        Ok((file, handle))
    }

    /// Returns the temporary path.
    pub(crate) fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Replaces an existing file, and returns the path.
    ///
    /// # Errors
    /// The operating system refused.
    pub(crate) fn replace(self, handle: &File) -> Result<PathBuf, DiskError> {
        handle.sync_data().with_path("sync", &self.temporary)?;
        std::fs::rename(&self.temporary, &self.path).with_path("replace", &self.path)?;
        Ok(self.path.clone())
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        // After the replacement no file has this name.
        let _ = std::fs::remove_file(&self.temporary);
    }
}
