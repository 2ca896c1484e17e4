//! Why there is no window.

use std::path::PathBuf;

use participant_window::lettering::NoFont;
use participant_window::place::PlaceError;
use participant_window::scales::ScalesError;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no screen.
    #[error(
        "no screen to open a window on: {0}; start it from a desktop, or set DISPLAY to that of the participant's monitor"
    )]
    NoScreen(&'static str),
    /// There is no such monitor.
    #[error("there is no monitor {asked}; there are: {}", .there.join(", "))]
    NoMonitor {
        /// What was asked for.
        asked: String,
        /// The monitors, with their numbers.
        there: Vec<String>,
    },
    /// Another window is open.
    #[error("the participant's window is open already: close that one first (Ctrl-Q in it)")]
    Second,
    /// Session and window cannot meet.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The monitors' scales cannot be read or kept.
    #[error(transparent)]
    Scales(#[from] ScalesError),
    /// The font file cannot be read.
    #[error("{}: {source}", .path.display())]
    FontFile {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// The font file is none.
    #[error("{}: {source}", .path.display())]
    Font {
        /// The file.
        path: PathBuf,
        /// What it is not.
        #[source]
        source: NoFont,
    },
    /// The window failed.
    #[error("the participant's window failed: {0}")]
    Failed(String),
}
