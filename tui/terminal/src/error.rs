//! Errors of the operator's screen.

use std::io;

/// Why the operator's screen ended.
#[derive(Debug, thiserror::Error)]
pub enum TerminalError {
    /// Standard input or output is not a terminal.
    #[error("no terminal for the dashboard ({}); run in a terminal, or with --headless", bounded_files::cause(.0))]
    NoTerminal(#[source] io::Error),
    /// The terminal understands no commands, by the variable `TERM`.
    #[error(
        "the terminal cannot show the dashboard, because TERM=dumb says that it prints lines only; use another terminal, or --headless"
    )]
    Dumb,
    /// The terminal failed while it was used, for example because its window was closed.
    #[error(
        "the terminal failed while {operation}: {}",
        bounded_files::cause(source)
    )]
    Terminal {
        /// Activity during the failure.
        operation: &'static str,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
}

impl TerminalError {
    /// Returns a function that wraps an error of the terminal during `operation`.
    pub fn while_doing(operation: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Terminal { operation, source }
    }
}
