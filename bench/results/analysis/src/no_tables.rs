//! Tables of a program built without Parquet: every request is rejected.

use std::path::Path;

use crate::findings::Analysis;

/// Tables cannot be written.
#[derive(Debug, thiserror::Error)]
#[error(
    "this program was built without Parquet, which the tables need; build it with `cargo build --release -p friction-bench \
     --features parquet`, or leave --tables out"
)]
pub struct TableError;

/// Requires that this program can write tables.
///
/// # Errors
/// Always.
pub fn require_built() -> Result<(), TableError> {
    Err(TableError)
}

/// Rejects the request without writing.
///
/// # Errors
/// Always.
pub fn write(_: &Analysis, _: &Path) -> Result<(), TableError> {
    Err(TableError)
}
