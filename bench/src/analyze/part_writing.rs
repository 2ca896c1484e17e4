//! `analyze --each`: a part for each recording.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use analysis_parts::{PartOutcome, PartState, PartsRequest, write_parts};
use anyhow::bail;
use escaping::escaped_line;
use study_analysis::warnings;

use super::inputs::{assumptions, request};
use super::warning_lines::print_warnings;
use crate::cli::Analyze;
use crate::outcome::{progress_bar, require_apart};
use crate::verbosity::Verbosity;

/// Writes the parts of the recordings into `folder` that are not there. Returns true if every recording has one, and no file
/// was found to differ from its recorded sum.
///
/// # Errors
/// Nothing to analyse, an option that parts do not have, or a part that cannot be written.
pub(super) fn run(options: &Analyze, folder: &Path, verbosity: Verbosity) -> anyhow::Result<bool> {
    if let Some(output) = options.output() {
        bail!(
            "--each writes parts only; leave out {output} here, and give it to `friction-bench analyze --from {}`",
            folder.display()
        );
    }
    require_apart(folder)?;
    let request = request(options);
    let found = request.find()?;
    print_warnings(&warnings::of_found(&found)?);
    let count = found.recordings().len();
    verbosity.note(format_args!("{count} recordings"));
    let bar = progress_bar(count as u64, verbosity);
    let parts = PartsRequest {
        request: &request,
        found: &found,
        assumptions: &assumptions(options)?,
        lab: options.lab.as_deref(),
        verify_inputs: options.verify_inputs,
    };
    let is_whole = AtomicBool::new(true);
    write_parts(folder, &parts, |outcome| {
        bar.suspend(|| print(outcome));
        bar.inc(1);
        if outcome.state == PartState::Failed || !outcome.changed.is_empty() {
            is_whole.store(false, Ordering::Relaxed);
        }
    })?;
    bar.finish_and_clear();
    Ok(is_whole.into_inner())
}

/// Prints the line of a recording, and its defects on standard error. A closed stream does not stop the analysis.
fn print(outcome: &PartOutcome) {
    let path = outcome.path.display().to_string();
    let path = escaped_line(&path);
    let mut lines: Vec<String> = outcome
        .analysis
        .iter()
        .flat_map(warnings::of_recording)
        .collect();
    let unread = outcome.unread.iter();
    lines.extend(unread.map(|reason| format!("{path}: cannot be read: {}", escaped_line(reason))));
    let remedy = outcome.remedy.iter();
    lines.extend(remedy.map(|remedy| format!("{path}: warning: {}", escaped_line(remedy))));
    let changed = outcome.changed.iter();
    lines.extend(changed.map(|file| {
        let file = file.display().to_string();
        format!(
            "{}: warning: differs from its sum in the session's log: it was changed since; `friction-bench verify` names all \
             such files, and a backup has the recorded one",
            escaped_line(&file)
        )
    }));
    print_warnings(&lines);
    let key = outcome.key.as_ref().map(ToString::to_string);
    let key = key.as_deref().unwrap_or("-");
    let _ = writeln!(
        standard_streams::data_out(),
        "{}\t{key}\t{path}",
        outcome.state.name()
    );
}
