//! `export`: a study in the formats of other programs.

use std::io::Write;

use escaping::{escaped, escaped_line};
use export::{ExportOptions, ExportOrigin, ExportedFiles, ExportedRecording, FileState};
use tasks::{Clock, SystemClock};

use crate::privacy;
use crate::verbosity::Verbosity;

/// Runs the command. Returns true if every recording was exported; the others are named on standard error.
///
/// # Errors
/// There is nothing to export, the target folder has other content, or a file of the whole study cannot be written.
pub fn run(options: &ExportOptions, verbosity: Verbosity) -> anyhow::Result<bool> {
    if !options.shared {
        privacy::keep_new_files_private();
    }
    let origin = ExportOrigin {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        day: SystemClock::start().day(),
    };
    let summary = export::export(options, &origin, |recording| report(recording, verbosity))?;
    let mut stderr = standard_streams::stderr();
    for left_out in &summary.left_out {
        let _ = writeln!(stderr, "warning: left out: {}", escaped_line(left_out));
    }
    for excluded in &summary.excluded {
        let _ = writeln!(stderr, "excluded from export: {}", escaped_line(excluded));
    }
    let target = options.to.display().to_string();
    writeln!(
        standard_streams::stdout(),
        "{} of {} recordings are in {}",
        summary.exported,
        summary.exported + summary.failed,
        escaped_line(&target)
    )?;
    Ok(summary.failed == 0)
}

/// Prints a line on a recording. A closed standard error does not stop the export.
fn report(recording: &ExportedRecording, verbosity: Verbosity) {
    let path = recording.recording.display().to_string();
    let path = escaped_line(&path);
    let mut stderr = standard_streams::stderr();
    match &recording.files {
        Ok(files) => {
            for missing in &files.missing {
                let _ = writeln!(stderr, "{path}: warning: {}", escaped(missing));
            }
            if verbosity.shows_progress() {
                let _ = writeln!(stderr, "{path}: {}", states(files));
            }
        }
        Err(error) => {
            let error = error.to_string();
            let _ = writeln!(stderr, "{path}: not exported: {}", escaped(&error));
        }
    }
}

/// Returns the numbers of files by their state, such as `2 files written, 1 unchanged`.
fn states(files: &ExportedFiles) -> String {
    let count = |state| files.states.iter().filter(|s| **s == state).count();
    let parts = [
        (count(FileState::Written), "written"),
        (count(FileState::Replaced), "replaced"),
        (count(FileState::Unchanged), "unchanged"),
    ];
    let parts = parts.iter().filter(|(n, _)| *n > 0);
    let text = |(index, (n, word)): (usize, &(usize, &str))| match (index, n) {
        (0, 1) => format!("1 file {word}"),
        (0, n) => format!("{n} files {word}"),
        (_, n) => format!("{n} {word}"),
    };
    parts.enumerate().map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_counted_by_their_state() {
        let files = ExportedFiles {
            states: vec![FileState::Unchanged, FileState::Written, FileState::Written],
            missing: Vec::new(),
        };
        assert_eq!(states(&files), "2 files written, 1 unchanged");
    }
}
