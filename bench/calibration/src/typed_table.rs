//! Tables that people write: CSV with a line of column names, blanks allowed.

use std::path::Path;

use anyhow::Context;
use serde::de::DeserializeOwned;

/// The rows of the table at `path`. `columns` tells its writer what they must be.
///
/// # Errors
/// When it cannot be read, or a row is not of these columns.
pub(super) fn rows<R: DeserializeOwned>(path: &Path, columns: &str) -> anyhow::Result<Vec<R>> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    reader
        .deserialize()
        .map(|row| {
            row.with_context(|| format!("{}: the columns must be {columns}", path.display()))
        })
        .collect()
}
