//! `analyze`: recordings to results.

mod inputs;
mod part_writing;
mod warning_lines;

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use self::inputs::{assumptions, request};
use self::warning_lines::print_warnings;
use crate::analyze_options::columns;
use crate::cli::Analyze;
use crate::dates;
use crate::outcome::{progress_bar, require_apart, require_writable, write_lines, write_text};
use crate::verbosity::Verbosity;
use analysis_parts::read_parts;
use escaping::{escaped, escaped_line};
use published_figures::measured::write_figures;
use published_statistics::{TableFormat, statistics};
use study::result_files::ResultFile;
use study_analysis::{StudyAnalysis, summary, warnings};

/// Name and version of the program, as a report states them.
const PROGRAM: &str = concat!("friction-bench ", env!("CARGO_PKG_VERSION"));

/// Runs the command. Returns true if every accepted trial was analysed, every recording could be read and has no flaw that makes its
/// numbers meaningless, and anything was estimated; defects are reported on standard error.
///
/// # Errors
/// Nothing to analyse, an assumption that cannot be made, or a result that cannot be written.
pub fn run(options: &Analyze, verbosity: Verbosity) -> anyhow::Result<bool> {
    if let Some(folder) = &options.out {
        return part_writing::run(options, folder, verbosity);
    }
    let files = [
        (&options.json, ResultFile::Json),
        (&options.report, ResultFile::Page),
    ];
    for (path, kind) in files {
        path.iter()
            .try_for_each(|path| require_writable(path, kind))?;
    }
    for folder in [&options.tables, &options.figures].into_iter().flatten() {
        require_apart(folder)?;
    }
    let study = match &options.from {
        Some(folder) => from_parts(options, folder)?,
        None => match from_recordings(options, verbosity)? {
            Some(study) => study,
            None => return Ok(false),
        },
    };
    print_warnings(&warnings::of_study(&study));
    write_files(options, &study, verbosity)?;
    print(options, &study)?;
    print_warnings(&warnings::of_outcome(&study));
    Ok(study.is_whole())
}

/// Analyses the recordings that the options name.
fn from_recordings(
    options: &Analyze,
    verbosity: Verbosity,
) -> anyhow::Result<Option<StudyAnalysis>> {
    let settings = assumptions(options)?.settings()?;
    let found = request(options).find()?;
    let count = found.recordings().len();
    verbosity.note(format_args!("{count} recordings"));
    let bar = progress_bar(count as u64, verbosity);
    let analysed = found.analyse(&settings, |analysis| {
        bar.suspend(|| print_warnings(&warnings::of_recording(analysis)));
        bar.inc(1);
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    Ok(analysed)
}

/// Puts the parts in `folder` together.
fn from_parts(options: &Analyze, folder: &Path) -> anyhow::Result<StudyAnalysis> {
    if let Some(option) = options.setting() {
        bail!(
            "--from takes recordings and settings from the parts: leave out {option} here; `friction-bench analyze --each` takes it"
        );
    }
    let study = read_parts(folder, |recording| {
        print_warnings(&warnings::of_recording(recording));
    })?;
    Ok(study)
}

/// Writes the files that the options name.
fn write_files(
    options: &Analyze,
    study: &StudyAnalysis,
    verbosity: Verbosity,
) -> anyhow::Result<()> {
    let report_written = |path: &Path| {
        if verbosity.shows_progress() && path != Path::new("-") {
            let path = path.display().to_string();
            let _ = writeln!(standard_streams::stderr(), "wrote {}", escaped_line(&path));
        }
    };
    let figures = options.figure_selection();
    if options.json.is_some() || options.report.is_some() {
        let results = study.results();
        if let Some(path) = &options.json {
            write_lines(path, |out| Ok(results.write_json(out)?))?;
            report_written(path);
        }
        if let Some(path) = &options.report {
            let page = study.page(&results, &figures, (dates::now(), PROGRAM));
            write_text(path, &page.context("cannot make the report")?)?;
            report_written(path);
        }
    }
    let mut paths = Vec::new();
    if let Some(folder) = &options.tables {
        paths.extend(study.write_tables(folder)?);
    }
    if let Some(folder) = &options.figures {
        let written = write_figures(study.with_series(), &study.sessions, &figures, folder);
        paths.extend(written.context("cannot draw the figures")?);
        paths.push(study.selection.write_table(folder)?);
    }
    paths.iter().for_each(|path| report_written(path));
    Ok(())
}

/// Prints the table that the options name, or a summary where no result is written to standard output.
fn print(options: &Analyze, study: &StudyAnalysis) -> anyhow::Result<()> {
    let format = options.table.format();
    match format {
        Some(TableFormat::Text { columns }) => {
            let text = summary::table(study, columns);
            write!(standard_streams::stdout(), "{}", escaped(&text))?;
        }
        Some(format) => {
            let text = statistics(&study.analysed).to_table(format);
            write!(standard_streams::data_out(), "{}", escaped(&text))?;
        }
        None => {}
    }
    let to_pipe = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    let is_summarised = options.json.is_none() && format.is_none() && !to_pipe(&options.report);
    if is_summarised {
        let text = summary::text(study, columns());
        write!(standard_streams::stdout(), "{}", escaped(&text))?;
    }
    let excluded = study.selection.to_text();
    // If another program reads the table, standard output has only the table.
    if is_summarised || matches!(format, Some(TableFormat::Text { .. })) {
        write!(standard_streams::stdout(), "{}", escaped(&excluded))?;
    } else {
        let _ = write!(standard_streams::stderr(), "{}", escaped(&excluded));
    }
    Ok(())
}
