//! An analysis with the attempts and exclusions that it rests on, and its outputs.

use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use analysis::findings::RecordingFindings;
use analysis::{Analysis, RecordingAnalysis, SeriesError, SeriesSource, Settings, analyse_into};
use attempts::{AttemptAccount, Attempts};
use descriptive::Description;
use jiff::Timestamp;
use plotting::Figure;
use population::skin::Skin;
use published_figures::measured::{FigureSelection, measured_figures};
use report::recording_results::Recording as RecordingResults;
use report::{Recorded, ReportContent, ReportError, Results};
use series_spool::SeriesSpool;
use study::exclusions::{self, ExclusionsError, RecordingSelection};
use study::sessions::Sessions;

use crate::found::Found;

/// Reasons why a page cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// The time series cannot be read.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// Reasons why the recordings found cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The exclusions of a study cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
    /// The time series cannot be kept.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

/// Analysis of the recordings found, and its reductions.
pub struct StudyAnalysis {
    /// Name of the analysed study, or of the recordings.
    pub name: String,
    /// Findings in the recordings.
    pub analysed: Analysis,
    /// Time series of the recordings.
    pub series: Box<dyn SeriesSource + Send>,
    /// Attempts found, with their standing.
    pub attempts: Attempts,
    /// Exclusions, and those that were overridden.
    pub selection: RecordingSelection,
    /// Account of the attempts.
    pub account: AttemptAccount,
    /// Friction, gap, force and amplitude of the trials, participants, conditions and the study.
    pub description: Description,
    /// Skin of the participants and of the study.
    pub skin: Skin,
    /// Sessions of the recordings.
    pub sessions: Sessions,
    /// Whether an accepted trial has a recording that was not analysed.
    pub is_damaged: bool,
}

impl StudyAnalysis {
    /// Reduces the analysis of the recordings found.
    ///
    /// # Errors
    /// The exclusions of a study cannot be read.
    pub fn new(
        found: Found,
        (analysed, series): (Analysis, impl SeriesSource + Send + 'static),
    ) -> Result<Self, ExclusionsError> {
        let excluded = excluded_recordings(&found.attempts, &found.selection)?;
        let folders = analysed.recordings.iter();
        let sessions = Sessions::from_recordings(folders.map(|recording| recording.path.as_path()));
        let with_series = (analysed, Box::new(series) as Box<dyn SeriesSource + Send>);
        let mut study = Self::assemble(found, with_series, (sessions, &excluded));
        study.is_damaged = study.account.missed().any(|attempt| attempt.path.exists());
        Ok(study)
    }

    /// Reduces an analysis of recordings in these sessions; `excluded` are the recordings left out on purpose.
    #[must_use]
    pub fn assemble(
        found: Found,
        (analysed, series): (Analysis, Box<dyn SeriesSource + Send>),
        (sessions, excluded): (Sessions, &[PathBuf]),
    ) -> Self {
        let Found {
            name,
            attempts,
            selection,
        } = found;
        Self {
            account: attempts.account(&analysed, excluded),
            description: Description::new(&analysed),
            skin: Skin::from_analysis(&analysed),
            is_damaged: false,
            sessions,
            name,
            analysed,
            series,
            attempts,
            selection,
        }
    }

    /// Returns the content of the results file.
    #[must_use]
    pub fn results(&self) -> Results<'_> {
        Results::new(&self.analysed, &self.skin, &self.account, &self.selection)
    }

    /// Returns the text of the results file.
    ///
    /// # Errors
    /// A path within it is not UTF-8.
    pub fn to_json(&self) -> serde_json::Result<String> {
        let mut text = Vec::new();
        self.results().write_json(&mut text)?;
        String::from_utf8(text).map_err(|error| serde_json::Error::io(io::Error::other(error)))
    }

    /// Returns the published figures that these recordings allow.
    ///
    /// # Errors
    /// The time series cannot be read.
    pub fn figures(&self, content: &FigureSelection) -> Result<Vec<Figure>, SeriesError> {
        measured_figures(self.with_series(), &self.sessions, content)
    }

    /// Returns the analysis with its time series.
    #[must_use]
    pub fn with_series(&self) -> (&Analysis, &dyn SeriesSource) {
        (&self.analysed, &*self.series)
    }

    /// Returns the results as one page of HTML, made at `date` by `program`.
    ///
    /// # Errors
    /// The time series cannot be read, or a figure cannot be drawn.
    pub fn page(
        &self,
        results: &Results<'_>,
        figures: &FigureSelection,
        (date, program): (Timestamp, &str),
    ) -> Result<String, PageError> {
        let recordings = self.analysed.recordings.iter();
        let rows: Vec<RecordingResults> = recordings.clone().map(RecordingResults::from).collect();
        let recordings = recordings.zip(&rows).map(|(recording, result)| Recorded {
            path: &recording.path,
            manifest: recording.findings.as_ref().ok().map(|f| &f.manifest),
            result,
        });
        let page = report::html(&ReportContent {
            name: &self.name,
            results,
            recordings: &recordings.collect::<Vec<_>>(),
            sessions: &self.sessions,
            figures: &self.figures(figures)?,
            date,
            program,
        })?;
        Ok(page)
    }

    /// Returns the content of the tables.
    #[must_use]
    pub fn tables(&self) -> tables::Content<'_> {
        tables::Content {
            analysed: &self.analysed,
            series: &*self.series,
            description: &self.description,
            attempts: &self.attempts,
            selection: &self.selection,
        }
    }

    /// Writes all tables, the skin and the exclusions into `folder`, and returns the paths.
    ///
    /// # Errors
    /// [`tables::TableError`], which names the file.
    pub fn write_tables(&self, folder: &Path) -> Result<Vec<PathBuf>, tables::TableError> {
        let mut paths = self.tables().write(folder)?;
        paths.push(population::skin::write(&self.skin, folder)?);
        paths.push(self.selection.write_table(folder)?);
        Ok(paths)
    }

    /// Returns whether every recording could be read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        let mut recordings = self.analysed.recordings.iter();
        recordings.all(|recording| recording.findings.is_ok())
    }

    /// Returns whether anything was estimated.
    #[must_use]
    pub fn has_result(&self) -> bool {
        self.analysed.findings().any(RecordingFindings::has_result)
    }

    /// Returns the number of the recordings of which the estimates are withheld.
    #[must_use]
    pub fn spoilt(&self) -> usize {
        let findings = self.analysed.findings();
        findings.filter(|findings| findings.is_spoilt()).count()
    }

    /// Returns whether every accepted trial was analysed, every recording could be read and has no flaw that makes its numbers
    /// meaningless, and anything was estimated. A part of a study, as on a medium of a few trials, is analysed like a whole one:
    /// `verify` judges whether a study is complete.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.is_read() && self.spoilt() == 0 && !self.is_damaged && self.has_result()
    }
}

impl Found {
    /// Analyses the recordings; `callback` is called after each one, from several threads. Returns `None` once `callback` broke
    /// off.
    ///
    /// # Errors
    /// The exclusions of a study cannot be read, or the time series cannot be kept.
    pub fn analyse(
        self,
        settings: &Settings,
        callback: impl Fn(&RecordingAnalysis) -> ControlFlow<()> + Sync,
    ) -> Result<Option<StudyAnalysis>, AnalysisError> {
        let spool = SeriesSpool::default();
        let analysed = analyse_into(&spool, self.recordings(), settings, callback)?;
        let study = analysed.map(|analysed| StudyAnalysis::new(self, (analysed, spool)));
        Ok(study.transpose()?)
    }
}

/// Returns the attempts that were excluded by decision, including those that could not be analysed anyway.
///
/// # Errors
/// The exclusions of a study cannot be read.
pub fn excluded_recordings(
    attempts: &Attempts,
    selection: &RecordingSelection,
) -> Result<Vec<PathBuf>, ExclusionsError> {
    let excluded = selection.excluded.iter();
    let mut recordings: Vec<PathBuf> = excluded.flat_map(|row| row.recordings.clone()).collect();
    if selection.overridden.is_empty() {
        let left_out = attempts.omissions.iter().map(|trial| trial.path.clone());
        let extra = exclusions::select(left_out.collect())?;
        recordings.extend(extra.excluded.into_iter().flat_map(|row| row.recordings));
    }
    Ok(recordings)
}
