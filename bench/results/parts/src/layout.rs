//! Places of files in a folder of parts.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::folder_name::partition;
use crate::key::Key;

/// Name of a participant or a laboratory that is not known.
pub(crate) const UNKNOWN: &str = "unknown";

/// Place of a part.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Place {
    pub(crate) lab: String,
    pub(crate) participant: String,
    pub(crate) key: Key,
}

/// Folder of parts.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) root: PathBuf,
}

impl Layout {
    pub(crate) fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
        }
    }

    /// Returns the file of a part: the rows of its instances, with all its findings.
    pub(crate) fn part(&self, place: &Place) -> PathBuf {
        let name = format!("{}.parquet", place.key);
        partitions(&self.root, place).join(name)
    }

    /// Returns the file of the time series of a part.
    pub(crate) fn series(&self, place: &Place) -> PathBuf {
        let name = format!("{}.cbor.gz", place.key);
        partitions(&self.root.join("series"), place).join(name)
    }

    /// Returns the file of the recording with this canonical path.
    pub(crate) fn entry(&self, recording: &Path) -> PathBuf {
        self.recordings()
            .join(file_name(&recording.to_string_lossy()))
    }

    /// Returns the file of a call that asked for the folders with these canonical paths.
    pub(crate) fn call(&self, folders: &[PathBuf]) -> PathBuf {
        let names: Vec<_> = folders.iter().map(|path| path.to_string_lossy()).collect();
        self.calls().join(file_name(&names.join("\n")))
    }

    /// Returns the file of the session with this canonical path.
    pub(crate) fn session(&self, folder: &Path) -> PathBuf {
        let sessions = self.index().join("sessions");
        sessions.join(file_name(&folder.to_string_lossy()))
    }

    pub(crate) fn calls(&self) -> PathBuf {
        self.index().join("calls")
    }

    pub(crate) fn recordings(&self) -> PathBuf {
        self.index().join("recordings")
    }

    fn index(&self) -> PathBuf {
        self.root.join("index")
    }
}

fn partitions(root: &Path, place: &Place) -> PathBuf {
    root.join(partition("lab", &place.lab))
        .join(partition("participant", &place.participant))
}

/// Returns a name of a file for a text of any length.
fn file_name(text: &str) -> String {
    let sum = format!("{:x}", Sha256::digest(text));
    format!("{}.cbor", &sum[..32])
}
