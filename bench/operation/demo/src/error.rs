//! Errors of a demonstration.

use std::path::PathBuf;

/// An error that ends a demonstration.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// The folder cannot be created.
    #[error(
        "cannot make a folder for the demonstration, {folder}: {}; name another: `friction-bench demo FOLDER`",
        bounded_files::cause(source)
    )]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// The program cannot be run.
    #[error(
        "cannot run {program} for the next step: {}",
        bounded_files::cause(source)
    )]
    Program {
        /// The program.
        program: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// Signals cannot be handled, or the output cannot be written.
    #[error(transparent)]
    System(#[from] std::io::Error),
}
