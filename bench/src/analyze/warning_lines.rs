//! Warnings of an analysis on standard error.

use std::io::Write;

/// Prints lines on standard error; a closed one does not stop the analysis.
pub(super) fn print_warnings(lines: &[String]) {
    let mut stderr = standard_streams::stderr();
    for line in lines {
        let _ = writeln!(stderr, "{line}");
    }
}
