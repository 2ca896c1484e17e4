//! Results of an analysis: as JSON, and as one self-contained HTML page without network, script or any other file.
//!
//! [`Results`] is the content of both, so that they cannot differ.

mod argument_words;
mod assumptions;
mod calibration;
mod content;
mod descriptive;
mod drawing;
mod drift;
mod estimates;
mod flags;
mod force_clocks;
mod instance;
mod law_check;
mod number;
mod omissions;
mod page;
mod priors;
pub mod recording_results;
mod results;
mod skin;
mod statistics;
mod study;
pub mod trial_quantity;
mod trials;

pub use argument_words::{in_arguments, warnings};
pub use content::{Recorded, ReportContent, ReportError};
pub use number::count_text;
pub use page::html;
pub use results::{FORMAT, Results};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
