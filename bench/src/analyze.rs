//! `analyze`: recordings to results.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::analyze_options::columns;
use crate::cli::Analyze;
use crate::dates;
use crate::outcome::{progress_bar, require_writable, write_text};
use crate::verbosity::Verbosity;
use analysis::attempts::{AttemptAccount, Attempts};
use analysis::find::TrialFilter;
use analysis::findings::{RecordingFindings, rejection_counts};
use analysis::whole_trial;
use analysis::{Analysis, RecordingAnalysis, SeriesSource, Settings, analyse_with_series, find};
use descriptive::Description;
use escaping::{escaped, escaped_line};
use plotting::Figure;
use population::law_check::{LawCheck, law_checks};
use population::skin::Skin;
use published_figures::measured::{measured_figures, write_figures};
use published_statistics::{TableFormat, statistics};
use recording::manifest::assumed_errors::assumed_terms;
use report::{Recorded, ReportContent, Results};
use study::exclusions::{EXCLUSIONS_FILE, RecordingSelection};
use study::sessions::Sessions;

/// Runs the command. Returns true if every accepted trial was analysed, every recording could be read and has no flaw that makes its
/// numbers meaningless, and anything was estimated; defects are reported on standard error.
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
    let scope = TrialFilter {
        practice: options.practice,
        rejected: options.include_rejected,
    };
    let attempts = find::attempts_except(&options.recordings, scope, &options.exclude)?;
    let selection = select(attempts.recordings(), options.include_excluded)?;
    let folders = &selection.recordings;
    verbosity.note(format_args!("{} recordings", folders.len()));
    let bar = progress_bar(folders.len() as u64, verbosity);
    let (analysed, series) = analyse_with_series(folders, &settings, |analysis| {
        bar.suspend(|| report(analysis));
        bar.inc(1);
    });
    bar.finish_and_clear();

    let with_series = (&analysed, &series as &dyn SeriesSource);
    let account = attempts.account(&analysed, &excluded_recordings(&attempts, &selection)?);
    warn(&account, &attempts);
    warn_of_provenance(&analysed);
    note_assumptions(&analysed);
    let description = Description::new(&analysed);
    let skin = Skin::from_analysis(&analysed);
    let sessions = Sessions::from_recordings(folders.iter().map(PathBuf::as_path));
    if options.json.is_some() || options.report.is_some() {
        let results = Results::new(&analysed, &skin, &account, &selection);
        if let Some(path) = &options.json {
            write_text(path, &results.to_json()?)?;
            report_written(path, verbosity);
        }
        if let Some(path) = &options.report {
            let figures = measured_figures(with_series, &sessions, &options.figure_selection())?;
            let page = page(options, &analysed, &results, (&sessions, &figures))?;
            write_text(path, &page)?;
            report_written(path, verbosity);
        }
    }
    if let Some(folder) = &options.tables {
        let content = tables::Content {
            analysed: &analysed,
            series: &series,
            description: &description,
            attempts: &attempts,
            selection: &selection,
        };
        let mut paths = content.write(folder)?;
        paths.push(population::skin::write(&skin, folder)?);
        paths.push(selection.write_table(folder)?);
        paths
            .iter()
            .for_each(|path| report_written(path, verbosity));
    }
    if let Some(folder) = &options.figures {
        let mut paths = write_figures(with_series, &sessions, &options.figure_selection(), folder)
            .context("cannot draw the figures")?;
        paths.push(selection.write_table(folder)?);
        paths
            .iter()
            .for_each(|path| report_written(path, verbosity));
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
        if let TableFormat::Text { columns } = format {
            text = counts.clone()
                + &recordings_without_instances(&analysed)
                + &description.to_text(columns)
                + "\n"
                + &text
                + &lines(&skin)
                + &law_lines(&analysed);
        }
        let mut out = match format {
            TableFormat::Text { .. } => standard_streams::stdout(),
            _ => standard_streams::data_out(),
        };
        write!(out, "{}", escaped(&text))?;
    }
    let to_pipe = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    let summarised = options.json.is_none() && table.is_none() && !to_pipe(&options.report);
    if summarised {
        let lines = description.to_text(columns())
            + &summary(&analysed)
            + &counts
            + &lines(&skin)
            + &law_lines(&analysed);
        write!(standard_streams::stdout(), "{}", escaped(&lines))?;
    }
    // If another program reads the table, standard output has only the table.
    if summarised || matches!(table, Some(TableFormat::Text { .. })) {
        write!(standard_streams::stdout(), "{}", escaped(&excluded))?;
    } else {
        let _ = write!(standard_streams::stderr(), "{}", escaped(&excluded));
    }
    let all_read = analysed.recordings.iter().all(|r| r.findings.is_ok());
    let spoilt = analysed
        .findings()
        .filter(|findings| findings.is_spoilt())
        .count();
    if spoilt > 0 {
        let total = analysed.recordings.len();
        let _ = writeln!(
            standard_streams::stderr(),
            "warning: the estimates of {spoilt} of {total} recordings are withheld: correct the recordings as the warnings say"
        );
    }
    let has_result = analysed.findings().any(RecordingFindings::has_result);
    if !has_result && all_read {
        let _ = writeln!(
            standard_streams::stderr(),
            "warning: nothing could be estimated: the reasons are above"
        );
    }
    // A part of a study, as on a medium of a few trials, is analysed as what it is: `verify` judges whether a study is complete.
    let damaged = account.missed().any(|attempt| attempt.path.exists());
    Ok(all_read && spoilt == 0 && !damaged && has_result)
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

/// Warns of copies, and of the accepted trials that are not in the analysis, except unreadable ones, which were reported already.
fn warn(account: &AttemptAccount, attempts: &Attempts) {
    let mut stderr = standard_streams::stderr();
    for copy in &attempts.copies {
        let copy = copy.to_string();
        let _ = writeln!(stderr, "warning: not counted: {}", escaped_line(&copy));
    }
    for trial in account.missed() {
        let _ = writeln!(stderr, "warning: left out: {}", escaped(&trial.to_string()));
    }
    for log in &account.unread_logs {
        let _ = writeln!(stderr, "warning: {}", escaped(log));
    }
}

/// Warns of recordings that are no calibrated measurement on a person, made with all stops.
fn warn_of_provenance(analysed: &Analysis) {
    let mut stderr = standard_streams::stderr();
    for count in &analysed.provenance().counts {
        let _ = writeln!(stderr, "warning: {}", escaped(&count.to_string()));
    }
}

/// Reports a file that was written, unless it is standard output.
fn report_written(path: &Path, verbosity: Verbosity) {
    if verbosity.shows_progress() && path != Path::new("-") {
        let path = path.display().to_string();
        let _ = writeln!(standard_streams::stderr(), "wrote {}", escaped_line(&path));
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
            standard_streams::stderr(),
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
    let mut stderr = standard_streams::stderr();
    match &analysis.findings {
        Ok(findings) => {
            for flaw in &findings.flaws {
                let _ = writeln!(stderr, "{path}: warning: {}", escaped(&flaw.to_string()));
            }
            if let Some(reasons) = rejections(findings) {
                let _ = writeln!(
                    stderr,
                    "{path}: warning: no instance: {}",
                    escaped(&reasons)
                );
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

/// Returns the kinds of a recording's rejected stretches with their numbers, if it has no instance.
fn rejections(findings: &RecordingFindings) -> Option<String> {
    if !findings.instances.is_empty() {
        return None;
    }
    let kinds = findings.rejected.iter().map(|stretch| &*stretch.kind);
    let counts = rejection_counts(kinds).into_iter();
    let counts: Vec<String> = counts.map(|(kind, n)| format!("{n} {kind}")).collect();
    (!counts.is_empty()).then(|| counts.join(", "))
}

/// Returns a line for each recording without an instance, with the reasons.
fn recordings_without_instances(analysed: &Analysis) -> String {
    let lines = analysed.findings().filter_map(|findings| {
        let path = findings.path.display().to_string();
        let text = rejections(findings)?;
        Some(format!(
            "{}: 0 instances, rejected: {text}\n",
            escaped_line(&path)
        ))
    });
    lines.collect()
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
            lines.extend(rejections(findings).map(|text| format!("  rejected: {text}\n")));
            let trial_lines = whole_trial::lines(findings);
            lines.extend(trial_lines.iter().map(|line| format!("  {line}\n")));
        }
    }
    lines
}
