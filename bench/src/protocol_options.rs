//! The command line of `protocol`.

use clap::{Args, Subcommand};

use crate::hardware_options::HardwareOptions;

/// `protocol`
#[derive(Debug, Args)]
#[command(arg_required_else_help = true, args_conflicts_with_subcommands = true)]
pub struct ProtocolOptions {
    /// Print a commented protocol that runs, to change; or by NAME a built-in one: huloux2021, consistency, demo.
    #[arg(long, value_name = "NAME", num_args = 0..=1)]
    pub template: Option<Option<String>>,
    #[command(subcommand)]
    #[expect(missing_docs, reason = "flattened")]
    pub command: Option<ProtocolCommand>,
}

/// The subcommands of `protocol`.
#[derive(Debug, Subcommand)]
pub enum ProtocolCommand {
    /// Check a protocol: its course in time, volts, micrometres, driving time, disk, and each demand that this bench refuses.
    ///
    /// Opens and drives nothing. Without a bench.toml it checks the file and the course only.
    Check(ProtocolCheck),
}

/// `protocol check`
#[derive(Debug, Args)]
pub struct ProtocolCheck {
    /// Protocol file, or a built-in protocol: huloux2021, consistency, demo.
    #[arg(value_name = "FILE")]
    pub protocol: String,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
}
