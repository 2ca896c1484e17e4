//! Command-line options of `friction-bench replay`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Pace of simulated or recorded time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Speed {
    /// Real time.
    Real,
    /// As fast as possible; with --mock, the same seed then gives the same files.
    Max,
}

/// Options of `replay`.
#[derive(Debug, Args)]
pub struct ReplayOptions {
    /// Folder of a recording, or of a study, participant or session to list its recordings.
    #[arg(value_name = "RECORDING|STUDY")]
    pub recording: PathBuf,
    /// Pace of the replay.
    #[arg(long, value_enum, default_value_t = Speed::Real)]
    pub speed: Speed,
    /// Print a few lines per exploration and totals instead of showing the dashboard.
    #[arg(long)]
    pub headless: bool,
}
