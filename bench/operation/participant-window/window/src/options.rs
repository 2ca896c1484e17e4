//! Options of the window.

use std::path::PathBuf;

/// Options of the window.
#[derive(Clone, Debug)]
pub struct Options {
    /// Socket of the session.
    pub socket: PathBuf,
    /// File of the monitors' scales.
    pub scales: PathBuf,
    /// Name or number of the monitor; by default the last one, usually next to the operator's.
    pub monitor: Option<String>,
    /// Whether to begin with the ruler page even if the monitor's scale is known.
    pub ruler: bool,
    /// Font file in place of the built-in font.
    pub font: Option<PathBuf>,
}
