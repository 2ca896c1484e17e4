//! The window on a screen: `friction-bench participant`.

mod app;
mod link;
mod monitor;
mod stage;

use std::path::PathBuf;

use winit::event_loop::EventLoop;

use crate::lettering::{NoFont, Typeface};
use crate::place::{self, PlaceError};
use crate::scales::{Scales, ScalesError};

/// Most bytes of a font file.
const FONT_LIMIT_BYTES: u64 = 64 << 20;

/// What the window is asked for.
#[derive(Clone, Debug)]
pub struct Options {
    /// Socket of the session.
    pub socket: PathBuf,
    /// File of the monitors' scales.
    pub scales: PathBuf,
    /// Name or number of the monitor; without it the last one, which is beside the operator's.
    pub monitor: Option<String>,
    /// Whether the window begins with the ruler page, though the monitor's scale is known.
    pub ruler: bool,
    /// Font file in place of the built-in font.
    pub font: Option<PathBuf>,
}

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

/// Returns the typeface of the options.
fn typeface(options: &Options) -> Result<Typeface, WindowError> {
    let Some(path) = &options.font else {
        return Typeface::built_in().map_err(|source| WindowError::Font {
            path: "the built-in font".into(),
            source,
        });
    };
    let file = files::read(path, FONT_LIMIT_BYTES).map_err(|source| WindowError::FontFile {
        path: path.clone(),
        source,
    })?;
    Typeface::read(file).map_err(|source| WindowError::Font {
        path: path.clone(),
        source,
    })
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// [`WindowError`].
pub fn run(options: Options) -> Result<(), WindowError> {
    let face = typeface(&options)?;
    let scales = Scales::read(&options.scales)?;
    let _only_one = place::only_window(&options.socket)?.ok_or(WindowError::Second)?;
    let events = EventLoop::new().map_err(|_| {
        // The library's own words name a line of its source.
        let named = std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty());
        WindowError::NoScreen(if named || cfg!(target_os = "macos") {
            "the display does not answer, or lets nobody in"
        } else {
            "DISPLAY is not set"
        })
    })?;
    let mut app = app::App::new(options, face, scales);
    let ended = events.run_app(&mut app);
    if let Some(error) = app.into_error() {
        return Err(error);
    }
    ended.map_err(|error| WindowError::Failed(error.to_string()))
}
