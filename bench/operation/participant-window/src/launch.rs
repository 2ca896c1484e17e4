//! The start of the window's program in place of the present process.

use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::participant_options::ParticipantOptions;

/// Name of the window's program.
pub const PROGRAM: &str = "friction-bench-participant";

/// Why the window's program did not start.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// The program was not found.
    #[error(
        "the participant's window is a separate program, friction-bench-participant, and is neither in {folder} nor on \
         the PATH: install it there, or build it with `cargo build --release -p friction-bench-participant`"
    )]
    Missing {
        /// Folder of the program that searched for it.
        folder: PathBuf,
    },
    /// The system refused to run it.
    #[error("{program} does not start: {}", bounded_files::cause(source))]
    Refused {
        /// The program.
        program: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
}

/// Replaces this process by the window's program, from the folder of `own` (this process's program) or else from the
/// PATH. The terminal, signals and the exit status then belong to the window. Returns only on failure.
pub fn launch(this_program: &Path, options: &ParticipantOptions) -> LaunchError {
    let folder = this_program.parent().unwrap_or(Path::new("."));
    let sibling = folder.join(PROGRAM);
    let program = if sibling.exists() {
        sibling
    } else {
        PROGRAM.into()
    };
    let source = Command::new(&program).args(options.arguments()).exec();
    if source.kind() == ErrorKind::NotFound {
        let folder = folder.to_owned();
        return LaunchError::Missing { folder };
    }
    LaunchError::Refused { program, source }
}
