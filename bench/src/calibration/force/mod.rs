//! `calibrate force`: the force sensor's zero, then known masses on one axis and on the other, each between two zeros.
//!
//! reading = tare + A · force + drift; the drift is taken out between the zeros before and after each mass, A is fitted
//! ([`metrology::crosstalk`]) and M = A⁻¹ kept. The plate stays silent throughout.

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

use super::operator::Axis;

const AXES: [Axis; 2] = [Axis::Normal, Axis::Lateral];
/// Windows at rest that make the first zero.
const TARE_WINDOWS: usize = 3;
/// Deviation that no reading undercuts, N: the last digit of a sensor that sends micronewtons.
const LEAST_SIGMA_N: f64 = 1e-6;
