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

/// Fails at once where [`write_text`] could not write after a long computation.
///
/// # Errors
/// `path` is a folder, or lies in one that does not exist or that this user cannot write into.
pub(crate) fn require_writable(path: &Path) -> anyhow::Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() || path.file_name().is_none() {
        anyhow::bail!(
            "cannot write {}: it is a folder; name a file",
            path.display()
        );
    }
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let probe = folder.join(format!(".friction-bench-{}", std::process::id()));
    std::fs::File::create_new(&probe)
        .and_then(|_| std::fs::remove_file(&probe))
        .with_context(|| {
            format!(
                "cannot write {}: name a file in a folder of yours",
                path.display()
            )
        })
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
