//! Trials that a study leaves out of its analysis, and why.
//!
//! [`read`] reads a study's [`EXCLUSIONS_FILE`], [`add`] appends to it, [`select`] parts recordings into those that are
//! analysed and those that are left out.

mod exclusion;
mod exclusions_error;
mod known;
mod report;
mod selection;
mod table;

pub use exclusion::{Exclusion, Part, Trial};
pub use exclusions_error::ExclusionsError;
pub use recording::study::EXCLUSIONS_FILE;
pub use selection::{Excluded, Selection, select, study_of};
pub use table::{Exclusions, add, read, to_tsv};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
