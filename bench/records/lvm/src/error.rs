//! Why an LVM file, or a cell in it, cannot be read.

use text_lines::TextLineError;

/// Why a file or a cell cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LvmError {
    /// A line cannot be read.
    #[error(transparent)]
    Line(#[from] TextLineError),
    /// A form that the header states and this reader does not read.
    #[error("{content}: {remedy}")]
    Unread {
        /// The form.
        content: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// A header is incomplete.
    #[error("line {line}: {defect}")]
    Damaged {
        /// Number of the line, from 1.
        line: u64,
        /// Description.
        defect: String,
    },
    /// A cell is not a number.
    #[error("line {line}, column {column}: {cell:?} {reason}")]
    Cell {
        /// Number of the line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// The cell.
        cell: String,
        /// Reason.
        reason: String,
    },
}
