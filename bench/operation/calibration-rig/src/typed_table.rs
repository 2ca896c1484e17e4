//! Tables typed by operators: CSV with a header line, blanks allowed.

use std::path::Path;

use anyhow::Context;
use serde::de::DeserializeOwned;

/// Reads the rows of the table at `path`; `columns` names the expected columns in errors.
///
/// # Errors
/// If the file cannot be read, or a row does not fit the columns.
pub fn rows<R: DeserializeOwned>(path: &Path, columns: &str) -> anyhow::Result<Vec<R>> {
    let table = bounded_files::read(path, bounded_files::TEXT_LIMIT_BYTES)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(&*table);
    reader
        .deserialize()
        .map(|row| {
            row.with_context(|| format!("{}: the columns must be {columns}", path.display()))
        })
        .collect()
}
