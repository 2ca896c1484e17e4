//! The demonstration, run with this program's own executable.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

use demo::{DemoEnd, DemoOptions};
use friction_bench::verbosity::Verbosity;

/// Runs the demonstration; returns the exit status of the step that failed, if one did.
pub fn run(options: &DemoOptions, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let arg0 = std::env::args_os().next().map(PathBuf::from);
    let arg0 = arg0.as_deref().unwrap_or(&program);
    let verbosity_flags: &[&str] = match verbosity {
        Verbosity::Quiet => &["--quiet"],
        Verbosity::Normal => &[],
        Verbosity::Verbose => &["--verbose"],
    };
    let bold = std::io::stdout().is_terminal();
    let stdout = standard_streams::stdout();
    Ok(
        match demo::run(options, (&program, arg0), verbosity_flags, stdout, bold)? {
            DemoEnd::Completed => ExitCode::SUCCESS,
            DemoEnd::Failed(status) => ExitCode::from(status),
        },
    )
}
