//! The bench's volts against an independent meter: `calibrate output`.
//!
//! A read-back finds an amplifier that changed, and never one wrong constant in both `volts_per_unit`. Here an operator
//! types what a meter across the actuators reads at a few levels, and the lines through these readings are judged.

mod output_procedure;
mod output_verdict;
#[cfg(test)]
mod tests;

pub use output_procedure::{OutputProcedure, OutputSetup, VoltMeter};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
