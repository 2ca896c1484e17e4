//! Pooling of estimates with known errors over trials, participants and a study.
//!
//! The estimates may be of any quantity; positive quantities are given as natural logarithms. Quantities are pooled one
//! by one, without the correlation of their errors.

mod estimate;
mod hierarchy;
mod mean;
mod scatter;

pub use estimate::Estimate;
pub use hierarchy::{Group, Hierarchy, Mean, Overall, Shrunken, hierarchy};
pub use mean::mean;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
