//! Check of the bench's volts against an independent meter: `calibrate output`.
//!
//! The read-back reveals an amplifier that has changed, but not the same wrong constant in both `volts_per_unit`. Here the
//! operator types the readings of a meter across the actuators at a few levels, and the lines through them are judged.

mod known_table;
mod output_procedure;
mod output_verdict;
#[cfg(test)]
mod tests;

pub use known_table::{KnownReadings, read_table};
pub use output_procedure::{OutputProcedure, OutputSetup, VoltMeter};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
