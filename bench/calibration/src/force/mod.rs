//! `calibrate force`: the force sensor's zero, then known masses on one axis and on the other, each between two zeros.
//!
//! reading = tare + A · force + drift; the drift is taken out between the zeros before and after each mass, A is fitted
//! ([`metrology::crosstalk`]) and M = A⁻¹ kept. The plate stays silent throughout.

mod common;
mod force_procedure;
mod force_setup;
mod force_verdict;
mod masses;
mod plateau;
#[cfg(test)]
mod tests;

pub use force_procedure::ForceProcedure;
pub use force_setup::ForceSetup;
pub use masses::{Accuracy, Mass, from_g, read_table};
