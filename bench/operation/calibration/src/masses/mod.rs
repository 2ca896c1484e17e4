//! `calibrate force`: measures the zero of the force sensor, then known masses on each axis, each between two zeros.
//!
//! reading = tare + A · force + drift. The drift is interpolated between the zeros before and after each mass, A is fitted
//! ([`metrology::crosstalk`]), and M = A⁻¹ is stored. The plate stays silent throughout.

mod common;
mod force_figure;
mod force_procedure;
mod force_setup;
mod force_verdict;
mod mass;
mod plateau;
#[cfg(test)]
mod tests;

pub use force_procedure::ForceProcedure;
pub use force_setup::ForceSetup;
pub use mass::{Accuracy, Mass, from_g, read_table};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
