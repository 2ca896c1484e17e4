//! What the window is asked for.

use std::path::PathBuf;

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
