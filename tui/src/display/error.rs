//! Why the participant's screen could not be opened.

use std::io;
use std::path::PathBuf;

/// Why the participant's screen could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The device could not be opened.
    #[error(
        "participant screen {path}: {}; give a terminal device that this user may write to",
        bounded_files::cause(source)
    )]
    Open {
        /// The device.
        path: PathBuf,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
    /// The device is not a terminal.
    #[error(
        "participant screen {path} is not a terminal; give one such as /dev/tty2 or /dev/pts/7"
    )]
    NotATerminal {
        /// The device.
        path: PathBuf,
    },
    /// The device is the operator's own terminal.
    #[error(
        "participant screen {path} is the operator's own terminal; give another, such as the one that `tty` prints in the \
         participant's terminal"
    )]
    Own {
        /// The device.
        path: PathBuf,
    },
    /// The drawing thread could not be started.
    #[error("participant screen: cannot start its thread: {}", bounded_files::cause(.0))]
    Thread(#[source] io::Error),
    /// This system has no terminal devices: a second terminal needs Unix (Linux, macOS).
    #[error(
        "participant screen {path}: a second terminal needs a Unix system such as Linux or macOS; run without it"
    )]
    NeedsUnix {
        /// The device asked for.
        path: PathBuf,
    },
}
