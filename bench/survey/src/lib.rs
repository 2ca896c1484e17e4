//! The plate beyond its constants: under a finger, for comparison with the bare one. None of it is a constant that the
//! bench computes with.

mod finger_procedure;
mod finger_verdict;
#[cfg(test)]
mod tests;

pub use finger_procedure::{FINGER_N, FINGER_V, FingerProcedure};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
