//! A table as CSV: UTF-8, commas, a header, decimal points; unknown values are empty.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use recording::DiskError;
use recording::disk::OnPath;

use crate::column::Table;
use crate::table_error::TableError;

/// Writes the table into `folder` and returns the path; it replaces an existing file when it is complete.
///
/// # Errors
/// The operating system refused.
pub(crate) fn write(table: &Table, folder: &Path) -> Result<PathBuf, TableError> {
    let path = folder.join(format!("{}.csv", table.name));
    let temporary = folder.join(format!("{}.csv.tmp", table.name));
    let result = write_rows(table, &temporary)
        .and_then(|()| std::fs::rename(&temporary, &path).with_path("replace", &path));
    if result.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    result?;
    Ok(path)
}

fn write_rows(table: &Table, path: &Path) -> Result<(), DiskError> {
    let file = File::create(path).with_path("create", path)?;
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    let names = table.columns.iter().map(|column| &*column.name);
    let csv_error = |error: csv::Error| match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        kind => std::io::Error::other(format!("{kind:?}")),
    };
    writer
        .write_record(names)
        .map_err(csv_error)
        .with_path("write", path)?;
    for row in 0..table.len() {
        let cells = table.columns.iter().map(|column| column.values.cell(row));
        writer
            .write_record(cells)
            .map_err(csv_error)
            .with_path("write", path)?;
    }
    let mut file = writer
        .into_inner()
        .map_err(|error| std::io::Error::other(error.to_string()))
        .with_path("write", path)?;
    file.flush().with_path("write", path)?;
    file.get_ref().sync_data().with_path("sync", path)
}
