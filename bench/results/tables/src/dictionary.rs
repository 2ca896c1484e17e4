//! Dictionary of the columns of all tables: unit and meaning of each.

use std::path::{Path, PathBuf};

use population::skin;
use recording::DiskError;
use recording::disk;
use serde::Serialize;

use crate::column::Table;

/// Name of the file.
pub const DICTIONARY_FILE: &str = "columns.csv";

/// Column of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Table, by the name of its files without their endings.
    pub table: &'static str,
    /// Name of the column.
    pub column: String,
    /// Type of its values: boolean, text, integer or real.
    #[serde(rename = "type")]
    pub type_name: &'static str,
    /// SI unit: `1` for a pure number, empty for a text or truth value.
    pub unit: &'static str,
    /// Meaning in a phrase.
    pub meaning: String,
}

/// Returns the entries of a table.
#[must_use]
pub fn entries(table: &Table) -> Vec<Entry> {
    let columns = table.columns.iter();
    columns
        .map(|column| Entry {
            table: table.name,
            column: column.name.to_string(),
            type_name: column.values.type_name(),
            unit: column.unit,
            meaning: column.meaning.to_string(),
        })
        .collect()
}

/// Returns the entries of `skin.csv`.
#[must_use]
pub fn skin_entries() -> Vec<Entry> {
    let columns = skin::COLUMNS.iter();
    columns
        .map(|&(column, type_name, unit, meaning)| Entry {
            table: "skin",
            column: column.to_owned(),
            type_name,
            unit,
            meaning: meaning.to_owned(),
        })
        .collect()
}

/// Writes the entries into `folder` and returns the path.
///
/// # Errors
/// The operating system refused.
pub fn write(entries: &[Entry], folder: &Path) -> Result<PathBuf, DiskError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for entry in entries {
        // Writing to memory does not fail.
        let _ = writer.serialize(entry);
    }
    let path = folder.join(DICTIONARY_FILE);
    disk::replace_file(&path, &writer.into_inner().unwrap_or_default())?;
    Ok(path)
}
