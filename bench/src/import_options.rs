//! The command line of `import`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

/// `import`
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("work").args(["look", "guess", "map"]).required(true))]
pub struct Import {
    /// Map of the files onto recordings, as `--guess` writes one.
    #[arg(value_name = "MAP")]
    pub map: Option<PathBuf>,
    /// Study folder; created if it does not exist.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["look", "guess"], required_unless_present_any = ["look", "guess", "dry_run"])]
    pub study: Option<PathBuf>,
    /// Create files with the umask's permissions [default: readable by you only].
    #[arg(long, requires = "study")]
    pub shared: bool,
    /// Convert every file and write nothing.
    #[arg(long, requires = "map", conflicts_with = "remove")]
    pub dry_run: bool,
    /// Take back the recordings that the map brought into the study, and nothing else.
    #[arg(long, requires_all = ["map", "study"])]
    pub remove: bool,
    /// List the arrays of files: type, shape, rate, unit, range, and what their spectrum shows.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub look: Vec<PathBuf>,
    /// Write a map with the reason of each line; lines to be checked are marked.
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "to")]
    pub guess: Vec<PathBuf>,
    /// File of the guessed map.
    #[arg(long, value_name = "MAP", requires = "guess")]
    pub to: Option<PathBuf>,
}
