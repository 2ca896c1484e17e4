//! Exclusion of trials from the analysis of a study.
//!
//! [`read`] reads a study's [`EXCLUSIONS_FILE`], [`add`] appends to it, and [`select`] splits recordings into analysed
//! and excluded ones.

mod exclusion;
mod exclusions_error;
mod known;
mod report;
mod selection;
mod table;

pub use exclusion::{AllOrOne, Exclusion, SessionTrial};
pub use exclusions_error::ExclusionsError;
pub use recording::study::EXCLUSIONS_FILE;
pub use selection::{Excluded, RecordingSelection, select, study_of};
pub use table::{Exclusions, add, cell, read, to_tsv, unread};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
