//! The plate beyond its constants: under a finger, and along its length. None of it is a constant that the bench computes
//! with.

mod finger_procedure;
mod finger_verdict;
mod profile_procedure;
mod profile_verdict;
#[cfg(test)]
mod tests;

pub use finger_procedure::{FINGER_N, FINGER_V, FingerProcedure};
pub use profile_procedure::{PLACES, Place, ProfileProcedure};
pub use profile_verdict::UNIFORM;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
