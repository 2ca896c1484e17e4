//! Tests of the plant, from drive samples to input samples, forces and truth.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

mod closed_forms;
mod laws;
mod rig;
mod unkind;
mod wide_finger;
