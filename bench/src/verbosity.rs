//! Amount of output on standard error in addition to warnings and errors.

use std::fmt;
use std::io::Write;

use escaping::escaped_line;

use crate::cli::Printing;

/// Amount of output on standard error in addition to warnings and errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Verbosity {
    /// No progress.
    Quiet,
    /// Progress.
    #[default]
    Normal,
    /// Progress, the files read, and the time taken.
    Verbose,
}

impl From<Printing> for Verbosity {
    fn from(printing: Printing) -> Self {
        match printing {
            Printing { quiet: true, .. } => Self::Quiet,
            Printing { verbose: true, .. } => Self::Verbose,
            Printing { .. } => Self::Normal,
        }
    }
}

impl Verbosity {
    /// Returns whether progress is printed.
    #[must_use]
    pub fn shows_progress(self) -> bool {
        self >= Self::Normal
    }

    /// Prints a line on standard error in verbose mode.
    pub fn note(self, text: fmt::Arguments<'_>) {
        if self == Self::Verbose {
            // A closed standard error is ignored.
            let text = text.to_string();
            let _ = writeln!(
                standard_streams::stderr(),
                "friction-bench: {}",
                escaped_line(&text)
            );
        }
    }

    /// Returns where progress is written: standard error, or nowhere.
    pub fn progress(self) -> Box<dyn Write + Send> {
        if self.shows_progress() {
            Box::new(standard_streams::stderr())
        } else {
            Box::new(std::io::sink())
        }
    }
}
