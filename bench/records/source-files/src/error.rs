//! Refusals of files and of names within them.

use std::io;
use std::path::PathBuf;

use flac_stream::Undecoded;
use text_lines::TextLineError;

use crate::file_format::Format;

/// Refusal of a file or of a name in it: the file, the place in it, the fault, and the remedy.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}{fault}", file.display(), place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default())]
pub struct SourceError {
    /// The file.
    pub file: PathBuf,
    /// Place in the file: a byte, a row and column, an array.
    pub place: Option<String>,
    /// The fault.
    pub fault: Box<SourceFault>,
}

impl SourceError {
    /// Creates a refusal of a place; [`crate::SourceFile`] adds the file.
    pub(crate) fn at(place: impl Into<String>, fault: SourceFault) -> Self {
        Self {
            file: PathBuf::new(),
            place: Some(place.into()),
            fault: Box::new(fault),
        }
    }

    /// Creates a refusal of contradictory or incomplete content at a place.
    pub(crate) fn damaged(place: impl Into<String>, finding: impl Into<String>) -> Self {
        Self::at(
            place,
            SourceFault::Damaged {
                finding: finding.into(),
            },
        )
    }
}

impl From<SourceFault> for SourceError {
    fn from(fault: SourceFault) -> Self {
        Self {
            file: PathBuf::new(),
            place: None,
            fault: Box::new(fault),
        }
    }
}

impl From<io::Error> for SourceError {
    fn from(error: io::Error) -> Self {
        SourceFault::System {
            cause: bounded_files::cause(&error),
        }
        .into()
    }
}

impl From<Undecoded> for SourceError {
    fn from(Undecoded { frame }: Undecoded) -> Self {
        let finding = "the samples from here on cannot be decoded";
        Self::damaged(format!("sample {frame}"), finding)
    }
}

impl From<TextLineError> for SourceError {
    fn from(error: TextLineError) -> Self {
        match error {
            TextLineError::Io(error) => error.into(),
            TextLineError::Long { line } => {
                Self::damaged(format!("line {line}"), "it is longer than a megabyte")
            }
        }
    }
}

/// Fault of a file or of a name in it, with the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceFault {
    /// The operating system refused.
    #[error("{cause}")]
    System {
        /// Reason and remedy.
        cause: String,
    },
    /// The file is of a kind that is not read.
    #[error("it is {kind}, which is not read: {remedy}")]
    Foreign {
        /// The kind, with its article.
        kind: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The content is of a kind that the format allows and the reader does not read.
    #[error("{content} is not read: {remedy}")]
    Unread {
        /// The content.
        content: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The samples of a sound file are of a kind that is not read.
    #[error("{fault}")]
    Sound {
        /// The fault, with its remedy.
        fault: String,
    },
    /// The content contradicts itself or ends early.
    #[error(
        "{finding}: the file is damaged; copy it again, or save it again from the program that made it"
    )]
    Damaged {
        /// The contradiction.
        finding: String,
    },
    /// The file has no numbers.
    #[error("no array of numbers is in this {format} file: is it the right file?")]
    NoNumbers {
        /// Format of the file.
        format: Format,
    },
    /// No array has the name.
    #[error("no array `{name}` is in it; it has {}", listed(.names))]
    NoArray {
        /// The name.
        name: String,
        /// Names of arrays, the most similar first.
        names: Vec<String>,
    },
    /// The name's indices do not choose one vector.
    #[error(
        "`{name}` is {shape}, and {selection}: name one column or row, as in `{example}`; indices start at 0"
    )]
    Selection {
        /// Name of the array.
        name: String,
        /// Its shape.
        shape: String,
        /// Contradiction of the indices.
        selection: String,
        /// A name that works.
        example: String,
    },
    /// A single number is needed.
    #[error(
        "`{name}` is {shape}, and one number is needed: name one element, as in `{name}[0]`, or write the number itself"
    )]
    NotScalar {
        /// The name.
        name: String,
        /// Shape of the array.
        shape: String,
    },
    /// A text or an attribute is not a number.
    #[error("`{name}` is the text {text:?}, and a number is needed: write the number itself")]
    NotNumber {
        /// The name.
        name: String,
        /// The text.
        text: String,
    },
    /// No attribute has the name.
    #[error("no attribute `{name}` is in it; it has {}", listed(.names))]
    NoAttribute {
        /// The name.
        name: String,
        /// Names of attributes, the most similar first.
        names: Vec<String>,
    },
    /// The array has no numbers that can be read.
    #[error("`{name}` is {content}, and numbers are needed: save it as an array of numbers")]
    NoValues {
        /// Name of the array.
        name: String,
        /// Its content, with its article.
        content: String,
    },
    /// The array is complex.
    #[error(
        "`{name}` has complex numbers, and real ones are needed: save real and imaginary part as two arrays"
    )]
    Complex {
        /// Name of the array.
        name: String,
    },
    /// The stretch is longer than the vector.
    #[error(
        "`{name}` has {length} values, and those up to {end} are needed: is it shorter than the others?"
    )]
    Range {
        /// Name of the array.
        name: String,
        /// Number of its values.
        length: u64,
        /// End of the stretch.
        end: u64,
    },
    /// Day and month of a date in a table may be exchanged.
    #[error(
        "{cell:?} may be day {} of month {} or day {} of month {}, and no day above 12 decides: write dates as in 2026-11-26",
        numbers[0], numbers[1], numbers[1], numbers[0]
    )]
    TwoDates {
        /// The cell.
        cell: String,
        /// Numbers at the start of the date.
        numbers: [i64; 2],
    },
    /// A cell of a table is not a number.
    #[error("{cell:?} {reason}: correct the cell, or leave it empty")]
    Cell {
        /// The cell.
        cell: String,
        /// Reason.
        reason: String,
    },
}

/// Number of names in a message.
const SHOWN_NAMES: usize = 8;

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let shown = names.iter().take(SHOWN_NAMES);
    let mut text = shown
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    if let Some(rest) = names
        .len()
        .checked_sub(SHOWN_NAMES)
        .filter(|rest| *rest > 0)
    {
        text += &format!(" and {rest} more");
    }
    text
}
