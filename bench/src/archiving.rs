//! `archive`: recordings as small archives.

use std::io::Write;
use std::sync::OnceLock;

use archive::{ArchiveOptions, ArchivedRecording, RecordingState};
use escaping::{escaped, escaped_line};

use crate::outcome::progress_bar;
use crate::privacy;
use crate::verbosity::Verbosity;

/// Runs the command. Returns true if every recording is in the archive; the others are named on standard error.
///
/// # Errors
/// There is nothing to archive, the target has other files, or a file of the whole study cannot be copied.
pub fn run(options: &ArchiveOptions, verbosity: Verbosity) -> anyhow::Result<bool> {
    if !options.shared {
        privacy::keep_new_files_private();
    }
    let bar = OnceLock::new();
    let begin = |recordings: usize| drop(bar.set(progress_bar(recordings as u64, verbosity)));
    let summary = archive::archive(options, env!("CARGO_PKG_VERSION"), begin, |recording| {
        if let Some(bar) = bar.get() {
            bar.suspend(|| report(recording, verbosity));
            bar.inc(1);
        }
    })?;
    if let Some(bar) = bar.get() {
        bar.finish_and_clear();
    }
    let target = options.to.display().to_string();
    writeln!(
        standard_streams::stdout(),
        "{} of {} recordings are in {}: {} of {}",
        summary.archived,
        summary.archived + summary.failed,
        escaped_line(&target),
        size(summary.archive_bytes),
        size(summary.original_bytes)
    )?;
    Ok(summary.failed == 0)
}

/// Prints a line on a recording. A closed standard error does not stop the archiving.
fn report(recording: &ArchivedRecording, verbosity: Verbosity) {
    let path = recording.recording.display().to_string();
    let path = escaped_line(&path);
    let mut stderr = standard_streams::stderr();
    let _ = match &recording.state {
        Ok((RecordingState::Copied { reason }, _)) => {
            writeln!(stderr, "{path}: copied as it is: {reason}")
        }
        Ok(_) if !verbosity.shows_progress() => Ok(()),
        Ok((RecordingState::Archived, bytes)) => {
            let (from, to) = (size(recording.bytes), size(*bytes));
            writeln!(stderr, "{path}: archived, {to} of {from}")
        }
        Ok((RecordingState::Kept, _)) => writeln!(stderr, "{path}: there already"),
        Err(error) => {
            let error = error.to_string();
            writeln!(stderr, "{path}: not archived: {}", escaped(&error))
        }
    };
}

/// Returns a number of bytes in words.
fn size(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
