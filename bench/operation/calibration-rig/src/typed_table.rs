//! Tables typed by operators, or saved by their spreadsheets and instruments.

use std::path::Path;

use anyhow::{Context, anyhow};
use text_tables::{Columns, Table, TableRow};

/// Reads the rows of the table at `path`.
///
/// # Errors
/// If the file cannot be read, or is not a table with these columns.
pub fn rows(path: &Path, columns: &Columns) -> anyhow::Result<Vec<TableRow>> {
    let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| anyhow!(bounded_files::cause(&error)))
        .with_context(|| format!("cannot read {}", path.display()))?;
    let table = Table::parse(&text, columns)
        .map_err(|fault| anyhow!("{}: {fault}; {}", path.display(), expected(columns)))?;
    Ok(table.rows)
}

fn expected(columns: &Columns) -> String {
    let required = columns.required.join(" and ");
    match columns.optional {
        [] => format!("its columns are {required}"),
        optional => format!(
            "its columns are {required}, and optionally {}",
            optional.join(", ")
        ),
    }
}
