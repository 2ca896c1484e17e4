//! Surveys of the plate: its response under a finger, its profile along the length, and its mode across the width.

mod across_verdict;
mod finger_procedure;
mod finger_verdict;
mod profile_procedure;
mod profile_verdict;
mod survey_axis;
#[cfg(test)]
mod tests;

pub use across_verdict::COSINE;
pub use finger_procedure::{FINGER_N, FINGER_V, FingerProcedure};
pub use profile_procedure::{ProfilePoint, ProfileProcedure};
pub use profile_verdict::UNIFORM;
pub use survey_axis::{PLACES, PLACES_ACROSS};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
