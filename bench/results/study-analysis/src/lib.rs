//! The analysis of recordings and studies as one step, for the command line and for Python.
//!
//! A [`Request`] names the folders; [`Request::find`] finds the recordings to analyse, [`Found::analyse`] analyses them, and the
//! [`StudyAnalysis`] that it returns makes results, page, figures and tables of them. [`warnings`] and [`summary`] are its texts.

mod found;
pub mod html;
mod in_memory;
mod request;
mod shared_numbers;
mod study_analysis;
pub mod summary;
mod unlike_drives;
pub mod warnings;

pub use found::Found;
pub use request::{Request, RequestError};
pub use study_analysis::{AnalysisError, PageError, StudyAnalysis, excluded_recordings};
