//! Options of `participant`.

use std::path::PathBuf;

use clap::Args;

/// `participant`
#[derive(Debug, Args)]
pub struct Participant {
    /// Monitor, by its name or its number from 1 [default: the last].
    #[arg(long, value_name = "NAME")]
    pub monitor: Option<String>,
    /// Begin with the ruler page, though this monitor's scale is known.
    #[arg(long)]
    pub ruler: bool,
    /// Font file (.ttf, .otf) for a language whose letters DejaVu Sans has not.
    #[arg(long, value_name = "FILE")]
    pub font: Option<PathBuf>,
    /// Socket of the session [default: the one that run opens].
    #[arg(long, value_name = "SOCKET")]
    pub socket: Option<PathBuf>,
}
