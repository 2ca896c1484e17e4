//! Why the operator's screen could not go on.

use std::io;

/// Why the operator's screen could not go on.
#[derive(Debug, thiserror::Error)]
pub enum TerminalError {
    /// Standard input or output is not a terminal.
    #[error("no terminal for the dashboard ({0}); run in a terminal, or with --headless")]
    NoTerminal(#[source] io::Error),
    /// The terminal failed while it was used, for example because its window was closed.
    #[error("the terminal failed while {doing}: {source}")]
    Terminal {
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
}

impl TerminalError {
    /// Returns what makes the error of a terminal that failed while `doing`.
    pub fn failed(doing: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Terminal { doing, source }
    }
}
