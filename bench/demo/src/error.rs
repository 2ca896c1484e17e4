//! Why a demonstration cannot go on.

use std::path::PathBuf;

/// Why a demonstration cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// Its folder cannot be made.
    #[error(
        "cannot make a folder for the demonstration, {folder}: {source}; name another: `friction-bench demo FOLDER`"
    )]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// The program cannot be run.
    #[error("cannot run {program} for the next step: {source}")]
    Program {
        /// This program.
        program: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// Signals cannot be handled, or what is printed cannot be written.
    #[error(transparent)]
    System(#[from] std::io::Error),
}
