//! `calibrate force`: the force sensor's zero, then known masses on one axis and on the other, each between two zeros.
//!
//! reading = tare + A · force + drift; the drift is taken out between the zeros before and after each mass, A is fitted
//! ([`metrology::crosstalk`]) and M = A⁻¹ kept. The plate stays silent throughout.

mod common;
mod judge;
mod masses;
mod plateau;
mod procedure;
mod setup;
#[cfg(test)]
mod tests;

pub use masses::{Accuracy, Mass, from_g, read_table};
pub use procedure::ForceProcedure;
pub use setup::Setup;
