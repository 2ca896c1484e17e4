//! The handbook's pages in docs/handbook.

use std::path::PathBuf;

use crate::program::workspace;

/// Set to 1 to write the handbook's generated files instead of comparing them.
pub const WRITE: &str = "FRICTION_BENCH_WRITE_HANDBOOK";

/// Returns the handbook's folder.
#[must_use]
pub fn folder() -> PathBuf {
    workspace().join("docs/handbook")
}
