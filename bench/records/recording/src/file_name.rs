//! Names of the files of a recording.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

use crate::{OTHER_FILES, sums};

/// Name of a file of a recording.
pub type FileName = &'static str;

/// Reads the name of a file of a recording, as in a stored finding.
///
/// # Errors
/// A recording has no file of this name.
pub fn file_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FileName, D::Error> {
    let name = String::deserialize(deserializer)?;
    let mut files = sums::FILES.into_iter().chain(OTHER_FILES);
    files
        .find(|file| *file == name)
        .ok_or_else(|| D::Error::custom(format!("a recording has no file `{name}`")))
}
