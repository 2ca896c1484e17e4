//! S, q0, η and τ of the participants of a study, from the fits of their recordings.

mod parameters;
mod table;
mod words;

pub use parameters::{
    LeftOut, Parameters, PersonParameter, PersonSkin, Ranged, RecordingSkin, Skin, StudyParameter,
    TrialParameter,
};
pub use table::{COLUMNS, SKIN_FILE, write};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
