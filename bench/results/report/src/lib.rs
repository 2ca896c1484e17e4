//! Results of an analysis as one self-contained HTML page: no network, no script, no other file.
//!
//! Every number of an estimate or a statistic is read from the text of the results that `analyze --json` writes, so
//! that the two cannot differ.

mod assumptions;
mod calibration;
mod content;
mod drift;
mod estimates;
mod flags;
mod number;
mod omissions;
mod page;
mod priors;
mod results;
mod skin;
mod statistics;
mod study;
mod trials;

pub use content::{Recorded, ReportContent, ReportError};
pub use page::html;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
