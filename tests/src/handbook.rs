//! The handbook: a book of docs/handbook.

use std::path::{Path, PathBuf};

use mdbook_driver::MDBook;

use crate::program::workspace;

/// Set to 1 to write what of the handbook the program makes itself, instead of comparing it.
pub const WRITE: &str = "FRICTION_BENCH_WRITE_HANDBOOK";

/// The handbook's folder.
#[must_use]
pub fn folder() -> PathBuf {
    workspace().join("docs/handbook")
}

/// Builds the handbook into `to`.
///
/// # Errors
/// When a chapter of SUMMARY.md does not exist, or a page cannot be written.
pub fn build(to: &Path) -> anyhow::Result<()> {
    let mut book = MDBook::load(folder())?;
    book.config.build.build_dir = to.to_owned();
    book.build()
}
