//! Crop and selection: finds the instances in an exploration.
//!
//! Huloux 2021 uses the central 60 mm of the plate, with the finger fully sliding at constant velocity, and only the
//! stretches in which friction falls because the vibration grows; an instance is 60 ms long. The paper leaves open some
//! points, which this project decides:
//!
//! - A *rising stretch* runs from a local minimum of the vibration amplitude to the next local maximum, both found in
//!   the amplitude itself, independent of the modulation's phase. Under noise of 1 % of the mean amplitude, for
//!   modulations of 1 to 50 Hz and any phase, its ends lie within 3 % of the modulation's period and 0.5 ms of the true
//!   ones (test `the_rises_found_are_those_of_the_modulation`).
//! - The *instance* is the middle 60 ms of a rising stretch, so every condition applies to those 60 ms alone.
//! - Speed is judged on its running mean over 20 ms: a step of the differentiated encoder signal is not a change of
//!   the finger's velocity.

mod explore;
mod rising;
mod select;
mod series;
#[cfg(test)]
mod tests;

pub use crate::rules::SelectionRules;
pub use crate::stretch::{Instance, Rejection, Stretch, StretchOutcome};
pub use explore::analyse_exploration;
pub use select::select;
pub use series::{ExplorationSeries, SelectionError, Validity};
