//! Why the window cannot open or has failed.

use std::path::PathBuf;

use participant_window::lettering::NoFont;
use participant_window::place::PlaceError;
use participant_window::scales::ScalesError;

/// Why the window cannot open or has failed.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No screen is available.
    #[error(
        "no screen to open a window on: {0}; start it from a desktop, or set DISPLAY to that of the participant's monitor"
    )]
    NoScreen(&'static str),
    /// The monitor does not exist.
    #[error("there is no monitor {name}; there are: {}", .monitors.join(", "))]
    NoMonitor {
        /// Monitor asked for.
        name: String,
        /// The monitors, with their numbers.
        monitors: Vec<String>,
    },
    /// Another window is open already.
    #[error("the participant's window is open already: close that one first (Ctrl-Q in it)")]
    Second,
    /// Session and window cannot meet.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The monitors' scales cannot be read or stored.
    #[error(transparent)]
    Scales(#[from] ScalesError),
    /// The font file cannot be read.
    #[error("cannot read {}: {}", .path.display(), bounded_files::cause(source))]
    FontFile {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// The font file is invalid.
    #[error("{}: {source}", .path.display())]
    Font {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        source: NoFont,
    },
    /// The window failed.
    #[error("the participant's window failed: {0}")]
    Failed(String),
}
