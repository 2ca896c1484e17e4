//! Surveys of the plate: its response under a finger, and its profile along the length. The bench computes with neither.

mod finger_procedure;
mod finger_verdict;
mod profile_procedure;
mod profile_verdict;
#[cfg(test)]
mod tests;

pub use finger_procedure::{FINGER_N, FINGER_V, FingerProcedure};
pub use profile_procedure::{PLACES, ProfilePoint, ProfileProcedure};
pub use profile_verdict::UNIFORM;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
