//! The command line of `analyze`.

use std::path::PathBuf;

use analysis::estimate::Method;
use clap::{Args, ValueEnum};
use published_figures::measured::FigureSelection;
use published_statistics::TableFormat;
use terminal_size::terminal_size_of;

/// Minimum number of columns that a table is made for.
const FEWEST_COLUMNS: u16 = 60;

/// `analyze`
#[derive(Debug, Args)]
pub struct Analyze {
    /// Folders of recordings, or of studies, participants or sessions to analyse all their accepted trials.
    #[arg(required_unless_present = "from", value_name = "RECORDING|STUDY")]
    pub recordings: Vec<PathBuf>,
    /// Analyse each recording on its own and write the findings as a part into --out, once: parts that are there are left, so that
    /// a run that was stopped continues, and several may run at once. Prints `done`, `kept` or `failed`, the key and the folder of
    /// each recording.
    #[arg(long, requires = "out")]
    pub each: bool,
    /// Folder of the parts.
    #[arg(long, value_name = "DIR", requires = "each")]
    pub out: Option<PathBuf>,
    /// Name of the laboratory in the parts, in place of the name of the study's folder.
    #[arg(long, value_name = "NAME", requires = "each")]
    pub lab: Option<String>,
    /// Compute the sums of all files anew instead of taking them from the session's log or an earlier run, and name the files that
    /// no longer have their recorded sum.
    #[arg(long, requires = "each")]
    pub verify_inputs: bool,
    /// Put the parts in this folder together, without the recordings: the results are those of `analyze` with the same recordings
    /// and settings.
    #[arg(long, value_name = "DIR", conflicts_with = "each")]
    pub from: Option<PathBuf>,
    /// Write the results as JSON; `-` for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write all results as one self-contained HTML page, to send to a co-author; `-` for standard output.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Table to print.
    #[command(flatten)]
    pub table: Table,
    /// Write the tables of instances, trials, participants and samples, for statistics programs, as CSV and Parquet, and
    /// columns.csv with the meaning of each column.
    #[arg(long, value_name = "DIR")]
    pub tables: Option<PathBuf>,
    /// Draw the published figures as SVG and PNG, with captions.
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Method shown in the figures.
    #[arg(
        long,
        value_name = "METHOD",
        value_enum,
        default_value_t,
        requires = "figures"
    )]
    pub figures_of: FiguresOf,
    /// Instances of the typical trial shown in Fig. 13.
    #[arg(
        long,
        value_name = "WHICH",
        value_enum,
        default_value_t,
        requires = "figures"
    )]
    pub instances_of: InstancesOf,
    /// Override an assumed value, such as contact_area_m2=314e-6; the names are those of `settings` in the results, with dots
    /// for nested tables: trial_priors.tau_s.median=2e-3. damping=ratio reads the published damping factor 0.3 as a damping
    /// ratio: loss_factor = 0.6.
    #[arg(long, value_name = "NAME=VALUE")]
    pub assume: Vec<String>,
    /// Override assumed values from a TOML file with NAME = VALUE on each line; --assume takes precedence.
    #[arg(long, value_name = "FILE")]
    pub assume_file: Vec<PathBuf>,
    /// Take the plate in `dynamic` as measured unloaded, instead of fitting its offset since then.
    #[arg(long)]
    pub no_offset: bool,
    /// Include practice trials.
    #[arg(long)]
    pub practice: bool,
    /// Also analyse trials that were not accepted: the last completed attempt of each.
    #[arg(long)]
    pub include_rejected: bool,
    /// Also analyse trials that the study's exclusions.tsv excludes.
    #[arg(long)]
    pub include_excluded: bool,
    /// Leave out the recordings in this folder, such as a backup within the study.
    #[arg(long, value_name = "FOLDER")]
    pub exclude: Vec<PathBuf>,
}

/// Table of statistics that `analyze` prints.
#[derive(Debug, Args)]
#[group(multiple = false)]
pub struct Table {
    /// Print a table of the published statistics and those of these recordings.
    #[arg(long)]
    pub table: bool,
    /// Print the table as CSV, each number in a separate column.
    #[arg(long)]
    pub table_csv: bool,
    /// Print the table in Markdown.
    #[arg(long)]
    pub table_markdown: bool,
    /// Print the table in LaTeX (booktabs).
    #[arg(long)]
    pub table_latex: bool,
}

impl Table {
    /// Returns the requested format.
    pub fn format(&self) -> Option<TableFormat> {
        [
            (self.table, TableFormat::Text { columns: columns() }),
            (self.table_csv, TableFormat::Csv),
            (self.table_markdown, TableFormat::Markdown),
            (self.table_latex, TableFormat::Latex),
        ]
        .into_iter()
        .find_map(|(is_set, format)| is_set.then_some(format))
    }
}

/// Returns the width in columns of the terminal that a table is printed on; `None` if it is not printed on one.
pub(crate) fn columns() -> Option<u16> {
    let (columns, _) = terminal_size_of(std::io::stdout())?;
    Some(columns.0.max(FEWEST_COLUMNS))
}

fn first_given(options: &[(bool, &'static str)]) -> Option<&'static str> {
    let given = options.iter().find(|(is_given, _)| *is_given);
    given.map(|(_, name)| *name)
}

/// Method shown in figures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum FiguresOf {
    /// As published.
    Paper,
    /// With envelope dynamics and levitation lag.
    Dynamic,
    /// With all parameters fitted to all instances of a recording together.
    Trial,
    /// `paper` and `dynamic`, in different inks.
    Both,
    /// Every method.
    #[default]
    All,
}

/// Instances shown in Fig. 13.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum InstancesOf {
    /// Instances of one exploration, as published.
    #[default]
    Exploration,
    /// Instances of the whole trial.
    Trial,
}

impl Analyze {
    /// Returns the first option that asks for an output.
    pub fn output(&self) -> Option<&'static str> {
        let table = &self.table;
        let options = [
            (self.json.is_some(), "--json"),
            (self.report.is_some(), "--report"),
            (self.tables.is_some(), "--tables"),
            (self.figures.is_some(), "--figures"),
            (table.table, "--table"),
            (table.table_csv, "--table-csv"),
            (table.table_markdown, "--table-markdown"),
            (table.table_latex, "--table-latex"),
        ];
        first_given(&options)
    }

    /// Returns the first option or argument that names recordings or settings.
    pub fn setting(&self) -> Option<&'static str> {
        let options = [
            (!self.recordings.is_empty(), "the recordings"),
            (!self.assume.is_empty(), "--assume"),
            (!self.assume_file.is_empty(), "--assume-file"),
            (self.no_offset, "--no-offset"),
            (self.practice, "--practice"),
            (self.include_rejected, "--include-rejected"),
            (self.include_excluded, "--include-excluded"),
            (!self.exclude.is_empty(), "--exclude"),
        ];
        first_given(&options)
    }

    /// Returns the content of the figures.
    pub fn figure_selection(&self) -> FigureSelection {
        let whole_trial = self.instances_of == InstancesOf::Trial;
        let methods = match self.figures_of {
            FiguresOf::Paper => vec![Method::Paper],
            FiguresOf::Dynamic => vec![Method::Dynamic],
            FiguresOf::Trial => vec![Method::Trial],
            FiguresOf::Both => vec![Method::Dynamic, Method::Paper],
            FiguresOf::All => FigureSelection::default().methods,
        };
        FigureSelection {
            methods,
            whole_trial,
        }
    }
}
