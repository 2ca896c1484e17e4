//! Options of every command that uses the bench.

use std::path::PathBuf;

use clap::Args;

/// Heading of the options that describe the bench.
pub(crate) const BENCH: &str = "Bench options";
/// Heading of the options of simulated hardware, the last of a command's own.
pub(crate) const SIMULATION: &str = "Simulation";

/// Options of every command that uses the bench.
#[derive(Debug, Clone, Args)]
pub struct HardwareOptions {
    /// Configuration of the bench [default: bench.toml, or that of the simulated bench with --mock].
    #[arg(long, value_name = "FILE", help_heading = BENCH)]
    pub config: Option<PathBuf>,
    /// Use simulated hardware, as described by a built-in scenario or a scenario file.
    #[arg(long, value_name = "SCENARIO", num_args = 0..=1, default_missing_value = "nominal", help_heading = SIMULATION)]
    pub mock: Option<String>,
    /// Seed of the simulated hardware and of all random choices [default: the protocol's].
    #[arg(long, value_parser = seed, allow_negative_numbers = true, help_heading = BENCH)]
    pub seed: Option<u64>,
    /// Print the effective configuration and exit; if there is no configuration yet, a commented template.
    #[arg(long, help_heading = BENCH)]
    pub print_config: bool,
    /// Calibration file [default: calibration.toml; with --mock, no file].
    #[arg(long, value_name = "FILE", help_heading = BENCH)]
    pub calibration: Option<PathBuf>,
}

fn seed(text: &str) -> Result<u64, String> {
    const LARGEST: u64 = i64::MAX as u64;
    text.parse()
        .ok()
        .filter(|seed| *seed <= LARGEST)
        .ok_or_else(|| format!("a seed is a whole number from 0 to {LARGEST}"))
}
