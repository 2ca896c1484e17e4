//! Copies of a session's protocol next to its recordings.

use std::path::{Path, PathBuf};

use recording::Manifest;

/// Returns the files next to a recording with this description that its selection rules depend on, which may be missing.
#[must_use]
pub fn protocol_copies(folder: &Path, manifest: &Manifest) -> Vec<PathBuf> {
    let Some((trial, session)) = manifest.trial.as_ref().zip(folder.parent()) else {
        return Vec::new();
    };
    let names = match &trial.protocol_file {
        Some(name) => vec![name.clone()],
        None => vec![
            format!("{}.toml", trial.protocol),
            second_copy(&trial.protocol),
        ],
    };
    // Only the name of a file in the session's folder is read.
    let names = names
        .iter()
        .filter(|name| Path::new(name).file_name() == Some(name.as_ref()));
    names.map(|name| session.join(name)).collect()
}

/// Returns the name of the second copy of a protocol: copies are numbered from 2 if the session was resumed after an edit.
#[must_use]
pub fn second_copy(protocol: &str) -> String {
    format!("{protocol}.2.toml")
}
