//! `import`: recordings made elsewhere.

use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::Path;

use escaping::escaped_line;
use import::{FileReport, Outcome, Plan, Program};

use crate::analyze_options::columns;
use crate::import_options::Import;
use crate::privacy;
use crate::verbosity::Verbosity;

/// Runs the command; returns false if a file was refused.
///
/// # Errors
/// The map, the study or a file to look at cannot be read, or the output cannot be written.
pub fn run(options: &Import, verbosity: Verbosity) -> anyhow::Result<bool> {
    if options.study.is_some() && !options.shared {
        privacy::keep_new_files_private();
    }
    let mut progress = progress_line(verbosity);
    let mut out = standard_streams::stdout();
    if !options.look.is_empty() {
        let unread = import_look::look(&options.look, columns(), &mut out, &mut progress)?;
        return Ok(unread == 0);
    }
    if let Some(to) = &options.to {
        let guess = import_look::guess(&options.guess, to, &mut progress)?;
        for unread in &guess.unread {
            writeln!(
                standard_streams::stderr(),
                "friction-bench: {}",
                escaped_line(unread)
            )?;
        }
        let lines = match guess.checks {
            0 => "no line is marked # CHECK".to_owned(),
            1 => "check the line marked # CHECK".to_owned(),
            count => format!("check the {count} lines marked # CHECK"),
        };
        writeln!(
            out,
            "{}: {lines}, then friction-bench import {} --dry-run",
            to.display(),
            escaping::quoted(to)
        )?;
        return Ok(guess.unread.is_empty());
    }
    let (Some(map), study) = (&options.map, options.study.as_deref()) else {
        anyhow::bail!("no map is named: friction-bench import MAP --study DIR");
    };
    if let (true, Some(study)) = (options.remove, study) {
        return take_back(map, study);
    }
    let plan = Plan::read(map)?;
    for note in plan.notes() {
        writeln!(out, "{}", escaped_line(note))?;
    }
    if let Some(space) = plan.trial_space(options.dry_run) {
        writeln!(out, "{}", escaped_line(&space.to_string()))?;
    }
    let program = Program {
        version: env!("FRICTION_BENCH_VERSION"),
    };
    let study = study.filter(|_| !options.dry_run);
    Ok(import::import(&plan, study, program, |report| {
        print(report, verbosity);
        ControlFlow::Continue(())
    })?)
}

/// Prints the lines of a file; a closed output does not stop the others.
fn print(report: &FileReport, verbosity: Verbosity) {
    let FileReport {
        file,
        recording,
        outcome,
        found,
        notes,
    } = report;
    let line = match outcome {
        Ok(Outcome::Written) => format!("{file} → {recording}"),
        Ok(Outcome::Replaced) => {
            format!("{file} → {recording}, in place of that of an earlier map")
        }
        Ok(Outcome::Unchanged) => format!("{file}: {recording} is there already"),
        Ok(Outcome::Checked) => format!("{file} would be {recording}"),
        Err(refusal) => format!("{file}: refused: {refusal}"),
    };
    let mut text = format!("{}\n", escaped_line(&line));
    for detail in found.iter().chain(notes) {
        text += &format!("  {}\n", escaped_line(detail));
    }
    let is_refused = outcome.is_err();
    if is_refused {
        let _ = standard_streams::stderr().write_all(text.as_bytes());
    } else if verbosity.shows_progress() {
        let _ = standard_streams::stdout().write_all(text.as_bytes());
    }
}

fn take_back(map: &Path, study: &Path) -> anyhow::Result<bool> {
    let mut out = standard_streams::stdout();
    let removal = import::remove(map, study)?;
    for recording in &removal.removed {
        writeln!(out, "{} is removed", escaped_line(recording))?;
    }
    if removal.removed.is_empty() {
        writeln!(
            out,
            "no recording in {} came from this map",
            escaped_line(&study.display().to_string())
        )?;
    }
    for note in &removal.notes {
        writeln!(out, "{}", escaped_line(note))?;
    }
    Ok(true)
}

/// Returns a line on a terminal's standard error that each call replaces.
fn progress_line(verbosity: Verbosity) -> impl FnMut(&str) {
    let is_shown = verbosity.shows_progress() && std::io::stderr().is_terminal();
    move |text: &str| {
        if is_shown {
            let _ = write!(standard_streams::stderr(), "\r\x1b[K{text}");
        }
    }
}
