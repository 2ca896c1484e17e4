//! How commands that go through many recordings show where they are, and write what they found.

use std::io::{IsTerminal, Write};
use std::path::Path;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use recording::disk;

use crate::verbosity::Verbosity;

/// Returns a bar on standard error; hidden where nobody watches.
pub(crate) fn progress_bar(recordings: u64, verbosity: Verbosity) -> ProgressBar {
    let target = if verbosity.shows_progress() && std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(recordings), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} recordings {eta}") {
        bar.set_style(style);
    }
    bar
}

/// Writes `text` to standard output for `-`, otherwise to a file that is whole or not there. Control characters are escaped
/// on the terminal, in the form that JSON has for them too.
///
/// # Errors
/// The system refused.
pub(crate) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    if path == Path::new("-") {
        std::io::stdout().write_all(tui::escaped(text).as_bytes())?;
        return Ok(());
    }
    disk::replace_file(path, text.as_bytes()).context("cannot write the results")
}
