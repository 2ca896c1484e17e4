//! Options of `list`.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use study::listing::ListedStanding;

/// `list`
#[derive(Debug, Args)]
pub struct List {
    /// Studies, participants, sessions or recordings; of a study every attempt, also rejected ones and practice.
    #[arg(required = true, value_name = "RECORDING|STUDY")]
    pub paths: Vec<PathBuf>,
    /// Format of the list.
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub format: ListFormat,
    /// Print the paths alone, byte by byte and each ended by NUL, as for xargs -0.
    #[arg(short = '0', long, conflicts_with = "format")]
    pub null: bool,
    /// List only these standings, such as accepted, and no practice trials.
    #[arg(long, value_name = "STANDING", value_parser = standings(), value_delimiter = ',')]
    pub only: Vec<ListedStanding>,
    /// List practice trials of these standings too.
    #[arg(long, requires = "only")]
    pub practice: bool,
}

/// Returns a parser of the standings by their words.
fn standings() -> impl TypedValueParser<Value = ListedStanding> {
    let words = ListedStanding::ALL.map(ListedStanding::word);
    PossibleValuesParser::new(words).map(|word| {
        let mut standings = ListedStanding::ALL.into_iter();
        let standing = standings.find(|standing| standing.word() == word);
        // The parser takes these words alone.
        standing.unwrap_or(ListedStanding::Unreadable)
    })
}

/// Format of `list`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ListFormat {
    /// A table with a header, its cells separated by tabs.
    #[default]
    Tsv,
    /// An array of objects.
    Json,
}
