//! Errors of a table of exclusions.

use std::path::PathBuf;

use bounded_files::Refusal;
use recording::DiskError;
use text_tables::TableFault;

/// Error of a table of exclusions. Lines count from 1, the header.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExclusionsError {
    /// The disk refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The file is not text.
    #[error("{}: {refusal}", path.display())]
    NoText {
        /// The file.
        path: PathBuf,
        /// Reason.
        refusal: Refusal,
    },
    /// The file is not a table with the needed columns, or a line has another number of cells.
    #[error(
        "{}: {fault}; the first line names participant_id, trial, reason and by, and each line has a cell for each column",
        path.display()
    )]
    Table {
        /// The file.
        path: PathBuf,
        /// Fault.
        fault: TableFault,
    },
    /// The header names an unknown column, or one column twice.
    #[error(
        "{}: `{column}` is not a column, or is there twice{}",
        path.display(),
        nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
    )]
    UnknownColumn {
        /// The file.
        path: PathBuf,
        /// Name in the header.
        column: String,
        /// Column with the most similar name.
        nearest: Option<String>,
    },
    /// A cell cannot be read.
    #[error("{}, line {line}: {column} is {value:?}: {why}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// The column.
        column: &'static str,
        /// The cell.
        value: String,
        /// Reason.
        why: String,
    },
    /// The study has no such participant, session or trial.
    #[error(
        "{}{}: {}",
        path.display(),
        line.map(|line| format!(", line {line}")).unwrap_or_default(),
        part.words()
    )]
    Unknown {
        /// The file, or the study for an exclusion that is being added.
        path: PathBuf,
        /// The line; `None` for an exclusion that is being added.
        line: Option<usize>,
        /// Missing participant, session or trial.
        part: Unknown,
    },
    /// The same exclusion exists already.
    #[error("{} leaves it out already: {existing}; edit that line to change the reason", path.display())]
    Already {
        /// The file.
        path: PathBuf,
        /// Existing exclusion.
        existing: String,
    },
}

/// Participant, session or trial that a study does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unknown {
    /// A participant.
    Participant {
        /// Given participant.
        participant: String,
        /// Participant with the most similar name.
        nearest: Option<String>,
    },
    /// A session.
    Session {
        /// Participant of the session.
        participant: String,
        /// Given session.
        session: u32,
        /// Existing sessions.
        existing: Vec<u32>,
    },
    /// A trial.
    Trial {
        /// Participant of the trial.
        participant: String,
        /// Given trial.
        trial: String,
        /// Recorded trials.
        existing: Vec<String>,
    },
}

impl Unknown {
    fn words(&self) -> String {
        match self {
            Self::Participant {
                participant,
                nearest,
            } => {
                let remedy = nearest.as_ref().map_or_else(
                    || "take the line out, or check the spelling".to_owned(),
                    |name| format!("did you mean `{name}`?"),
                );
                format!("the study has no participant {participant}; {remedy}")
            }
            Self::Session {
                participant,
                session,
                existing,
            } => format!(
                "{participant} has no session {session}; there are {}",
                list_text(existing)
            ),
            Self::Trial {
                participant,
                trial,
                existing,
            } => format!(
                "{participant} has no recording of trial {trial}; there are {}",
                list_text(existing)
            ),
        }
    }
}

fn list_text<T: ToString>(values: &[T]) -> String {
    const MAX_NAMES: usize = 20;
    if values.is_empty() {
        return "none".to_owned();
    }
    let names: Vec<_> = values
        .iter()
        .take(MAX_NAMES)
        .map(ToString::to_string)
        .collect();
    let n_more = values.len().saturating_sub(MAX_NAMES);
    match n_more {
        0 => names.join(", "),
        _ => format!("{} and {n_more} more", names.join(", ")),
    }
}
