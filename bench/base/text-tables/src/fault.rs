//! Faults of a table.

use crate::number::NumberFault;
use crate::separator::Separator;

/// Fault of a table; the message does not name the file, the caller's report does. Lines count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TableFault {
    /// The file has no header.
    #[error("it is empty; its first line must name columns: {}", listed(.columns))]
    Empty {
        /// Required columns.
        columns: Vec<String>,
    },
    /// The header lacks a column.
    #[error(
        "no column `{column}`; its header is `{header}`, read as cells separated by {}{}",
        separator.name(),
        nearest.as_ref().map(|name| format!("; if `{name}` is that column, rename it, and convert its numbers to \
         the unit in the name")).unwrap_or_default()
    )]
    MissingColumn {
        /// The column.
        column: String,
        /// Header of the file.
        header: String,
        /// Separator of its cells.
        separator: Separator,
        /// Column that may be meant.
        nearest: Option<String>,
    },
    /// A column has the name of an optional one, in another unit.
    #[error(
        "the column `{found}` is not read; rename it to `{column}`, and convert its numbers to {unit}"
    )]
    OtherUnit {
        /// The column in the file.
        found: String,
        /// The column that is read.
        column: String,
        /// Unit of that column.
        unit: &'static str,
    },
    /// The header names a column twice.
    #[error("the column `{column}` is there twice; keep one of them")]
    Twice {
        /// The column.
        column: String,
    },
    /// The cells have another separator than the file's kind.
    #[error(
        "line {line}: its cells are separated by {}, and this table needs tabs; save it as tab-separated text",
        separator.name()
    )]
    NotTabs {
        /// The line.
        line: usize,
        /// Separator of its cells.
        separator: Separator,
    },
    /// The number of cells in a line differs from that of the header.
    #[error("line {line}: {cells} cells where the header has {columns}; they are separated by {}", separator.name())]
    Cells {
        /// The line.
        line: usize,
        /// Number of its cells.
        cells: usize,
        /// Number of cells in the header.
        columns: usize,
        /// Separator of the cells.
        separator: Separator,
    },
    /// Commas separate cells and may be decimal signs too.
    #[error(
        "line {line}: {cells} cells where the header has {columns}: a comma that separates cells cannot be a decimal comma \
         too; write decimal points, or separate cells by semicolons or tabs"
    )]
    DecimalCommas {
        /// The line.
        line: usize,
        /// Number of its cells.
        cells: usize,
        /// Number of cells in the header.
        columns: usize,
    },
    /// A cell is not a number.
    #[error("line {line}, column `{column}`: {cell:?}: {fault}")]
    Number {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The cell.
        cell: String,
        /// Reason.
        fault: NumberFault,
    },
    /// A cell is empty.
    #[error("line {line}: the column `{column}` is empty")]
    EmptyCell {
        /// The line.
        line: usize,
        /// The column.
        column: String,
    },
    /// The row of units contradicts a column's name.
    #[error(
        "line {line} is a row of units, and states {found:?} for the column `{column}`: convert its numbers to {unit}, or \
         correct the row"
    )]
    UnitsRow {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// Unit in the row.
        found: String,
        /// Unit in the column's name.
        unit: &'static str,
    },
}

fn listed(columns: &[String]) -> String {
    columns.join(", ")
}
