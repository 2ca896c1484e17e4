//! Tables typed by operators, or saved by their spreadsheets and instruments.

use std::path::Path;

use anyhow::{Context, anyhow};
use text_tables::{Columns, Table, TableFault, TableRow};

/// Reads the rows of the table at `path`.
///
/// # Errors
/// If the file cannot be read, or is not a table with these columns.
pub fn rows(path: &Path, columns: &Columns) -> anyhow::Result<Vec<TableRow>> {
    let (_, rows) = rows_of_either(path, [columns, columns])?;
    Ok(rows)
}

/// Reads the rows of the table at `path`, which has the columns of the first layout or else of the second; returns the index of
/// the layout.
///
/// # Errors
/// As [`rows`]; of a table of neither layout, that of the first.
pub fn rows_of_either(
    path: &Path,
    layouts: [&Columns; 2],
) -> anyhow::Result<(usize, Vec<TableRow>)> {
    let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| anyhow!(bounded_files::cause(&error)))
        .with_context(|| format!("cannot read {}", path.display()))?;
    let [first, second] = layouts;
    let (index, table) = match Table::parse(&text, first) {
        Err(fault @ TableFault::MissingColumn { .. }) => match Table::parse(&text, second) {
            Err(TableFault::MissingColumn { .. }) => (0, Err(fault)),
            other => (1, other),
        },
        other => (0, other),
    };
    let table = table
        .map_err(|fault| anyhow!("{}: {fault}; {}", path.display(), expected(layouts[index])))?;
    Ok((index, table.rows))
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
