//! `analyze`: recordings to results.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::cli::Analyze;
use crate::dates;
use crate::outcome::{progress_bar, require_writable, write_text};
use crate::verbosity::Verbosity;
use analysis::attempts::{AttemptAccount, Attempts};
use analysis::find::TrialFilter;
use analysis::published::{TableFormat, statistics};
use analysis::whole_trial;
use analysis::{Analysis, RecordingAnalysis, Settings, analyse, find, tables};
use escaping::{escaped, escaped_line};
use plotting::Figure;
use population::law_check::{LawCheck, law_checks};
use population::skin::Skin;
use published_figures::measured::{measured_figures, write_figures};
use recording::manifest::assumed_errors::assumed_terms;
use report::{Recorded, ReportContent, Results};
use study::exclusions::{EXCLUSIONS_FILE, RecordingSelection};
use study::sessions::Sessions;

/// Runs the command. Returns true if every accepted trial was analysed and every recording could be read; defects are
/// reported on standard error.
///
/// # Errors
/// Nothing to analyse, an assumption that cannot be made, or a result that cannot be written.
pub fn run(options: &Analyze, verbosity: Verbosity) -> anyhow::Result<bool> {
    let mut settings = Settings::default();
    for path in &options.assume_file {
        let file = path.display().to_string();
        let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
            .with_context(|| format!("cannot read {file}"))?;
        settings.assume_file(&text, &file)?;
    }
    for assumption in &options.assume {
        settings.assume(assumption)?;
    }
    settings.plate_offset = !options.no_offset;
    for path in [&options.json, &options.report].into_iter().flatten() {
        require_writable(path)?;
    }
    if options.tables.is_some() {
        tables::require_built()?;
    }
    let scope = TrialFilter {
        practice: options.practice,
        rejected: options.include_rejected,
    };
    let attempts = find::attempts(&options.recordings, scope)?;
    let selection = select(attempts.recordings(), options.include_excluded)?;
    let folders = &selection.recordings;
    verbosity.note(format_args!("{} recordings", folders.len()));
    let bar = progress_bar(folders.len() as u64, verbosity);
    let analysed = analyse(folders, &settings, |analysis| {
        bar.suspend(|| report(analysis));
        bar.inc(1);
    });
    bar.finish_and_clear();

    let account = attempts.account(&analysed, &excluded_recordings(&attempts, &selection)?);
    warn(&account);
    note_assumptions(&analysed);
    let skin = Skin::from_analysis(&analysed);
    let sessions = Sessions::from_recordings(folders.iter().map(PathBuf::as_path));
    if options.json.is_some() || options.report.is_some() {
        let results = Results::new(&analysed, &skin, &account, &selection);
        if let Some(path) = &options.json {
            write_text(path, &results.to_json()?)?;
        }
        if let Some(path) = &options.report {
            let figures = measured_figures(&analysed, &sessions, &options.figure_selection());
            let page = page(options, &analysed, &results, (&sessions, &figures))?;
            write_text(path, &page)?;
        }
    }
    if let Some(folder) = &options.tables {
        tables::write(&analysed, folder)?;
        population::skin::write(&skin, folder)?;
        selection.write_table(folder)?;
    }
    if let Some(folder) = &options.figures {
        write_figures(&analysed, &sessions, &options.figure_selection(), folder)
            .context("cannot draw the figures")?;
        selection.write_table(folder)?;
    }
    let excluded = selection.to_text();
    let counts: String = account
        .lines()
        .into_iter()
        .map(|line| line + "\n")
        .collect();
    let table = options.table.format();
    if let Some(format) = table {
        let mut text = statistics(&analysed).to_table(format);
        if matches!(format, TableFormat::Text { .. }) {
            text = counts.clone() + &text + &lines(&skin) + &law_lines(&analysed);
        }
        write!(std::io::stdout(), "{}", escaped(&text))?;
    }
    let to_pipe = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    let summarised = options.json.is_none() && table.is_none() && !to_pipe(&options.report);
    if summarised {
        let lines = summary(&analysed) + &counts + &lines(&skin) + &law_lines(&analysed);
        write!(std::io::stdout(), "{}", escaped(&lines))?;
    }
    // If another program reads the table, standard output has only the table.
    if summarised || matches!(table, Some(TableFormat::Text { .. })) {
        write!(std::io::stdout(), "{}", escaped(&excluded))?;
    } else {
        let _ = write!(std::io::stderr(), "{}", escaped(&excluded));
    }
    let all_read = analysed.recordings.iter().all(|r| r.findings.is_ok());
    Ok(all_read && account.missed().next().is_none())
}

/// Returns the attempts that were excluded by decision, including those that could not be analysed anyway.
fn excluded_recordings(
    attempts: &Attempts,
    selection: &RecordingSelection,
) -> anyhow::Result<Vec<PathBuf>> {
    let excluded = selection.excluded.iter();
    let mut recordings: Vec<PathBuf> = excluded.flat_map(|row| row.recordings.clone()).collect();
    if selection.overridden.is_empty() {
        let left_out = attempts.omissions.iter().map(|trial| trial.path.clone());
        let extra = study::exclusions::select(left_out.collect())?;
        recordings.extend(extra.excluded.into_iter().flat_map(|row| row.recordings));
    }
    Ok(recordings)
}

/// Warns of the accepted trials that are not in the analysis, except unreadable ones, which were reported already.
fn warn(account: &AttemptAccount) {
    let mut stderr = std::io::stderr().lock();
    for trial in account.missed() {
        let _ = writeln!(stderr, "warning: left out: {}", escaped(&trial.to_string()));
    }
    for log in &account.unread_logs {
        let _ = writeln!(stderr, "warning: {}", escaped(log));
    }
}

/// Reports the standard errors that are assumed of the recordings' constants.
fn note_assumptions(analysed: &Analysis) {
    let budgets = analysed
        .findings()
        .map(|findings| findings.errors.assumptions);
    let terms = assumed_terms(&budgets.collect::<Vec<_>>());
    if !terms.is_empty() {
        let _ = writeln!(
            std::io::stderr(),
            "note: the total intervals include standard errors assumed of constants of which a recording neither states nor shows \
             the error: {}; calibrate the bench, or state them in recording.toml ([standard_errors], [room])",
            terms.join(", ")
        );
    }
}

/// Returns the report on the analysis.
fn page(
    options: &Analyze,
    analysed: &Analysis,
    results: &Results<'_>,
    (sessions, figures): (&Sessions, &[Figure]),
) -> anyhow::Result<String> {
    let recordings = analysed.recordings.iter().map(|recording| Recorded {
        path: &recording.path,
        manifest: recording.findings.as_ref().ok().map(|f| &f.manifest),
    });
    let content = ReportContent {
        name: &name(&options.recordings),
        results,
        recordings: &recordings.collect::<Vec<_>>(),
        sessions,
        figures,
        date: dates::now(),
        program: concat!("friction-bench ", env!("CARGO_PKG_VERSION")),
    };
    report::html(&content).context("cannot make the report")
}

/// Returns the names of the requested folders, without their paths.
fn name(folders: &[PathBuf]) -> String {
    let names = folders.iter().map(|folder| {
        let path = folder.canonicalize().unwrap_or_else(|_| folder.clone());
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    });
    names.collect::<Vec<_>>().join(", ")
}

/// Splits the recordings by the exclusions of their studies; `everything` analyses them all.
fn select(folders: Vec<PathBuf>, include_excluded: bool) -> anyhow::Result<RecordingSelection> {
    let all_folders = folders.clone();
    let selection = study::exclusions::select(folders)?;
    if include_excluded {
        return Ok(selection.overridden(all_folders));
    }
    if selection.recordings.is_empty() {
        bail!(
            "nothing is left to analyse: {EXCLUSIONS_FILE} leaves out {}; --include-excluded analyses it all the same",
            selection.lines().join("; ")
        );
    }
    Ok(selection)
}

/// Reports the defects of a recording. A closed standard error does not stop the analysis.
fn report(analysis: &RecordingAnalysis) {
    let path = analysis.path.display().to_string();
    let path = escaped_line(&path);
    let mut stderr = std::io::stderr().lock();
    match &analysis.findings {
        Ok(findings) => {
            for flaw in &findings.flaws {
                let _ = writeln!(stderr, "{path}: warning: {}", escaped(&flaw.to_string()));
            }
        }
        Err(error) => {
            let _ = writeln!(
                stderr,
                "{path}: cannot be read: {}",
                escaped(&error.to_string())
            );
        }
    }
}

fn lines(skin: &Skin) -> String {
    skin.lines().into_iter().map(|line| line + "\n").collect()
}

/// Returns the lines of the participants with trials under several conditions.
fn law_lines(analysed: &Analysis) -> String {
    let checks = law_checks(analysed);
    let lines = checks.iter().flat_map(LawCheck::lines);
    lines.map(|line| line + "\n").collect()
}

/// Returns a line for each recording, and one for the parameters that its instances share.
fn summary(analysed: &Analysis) -> String {
    let mut lines = String::new();
    for recording in &analysed.recordings {
        let counts = match &recording.findings {
            Ok(findings) => format!(
                "{} instances, {} stretches rejected, {} warnings",
                findings.instances.len(),
                findings.rejected.len(),
                findings.flaws.len()
            ),
            Err(_) => "cannot be read".to_owned(),
        };
        lines.push_str(&format!(
            "{}: {counts}\n",
            escaped_line(&recording.path.display().to_string())
        ));
        if let Ok(findings) = &recording.findings {
            let trial_lines = whole_trial::lines(findings);
            lines.extend(trial_lines.iter().map(|line| format!("  {line}\n")));
        }
    }
    lines
}
