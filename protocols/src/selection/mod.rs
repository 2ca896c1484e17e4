//! Crop and selection: which stretches of an exploration are instances.
//!
//! Huloux 2021 keeps the central 60 mm of the plate, the finger fully sliding at constant velocity, and only the
//! stretches where friction falls because the vibration grows; an instance is 60 ms long. What the paper leaves open
//! this project decides:
//!
//! - A *rising stretch* runs from a local minimum of the vibration amplitude to the next local maximum, both found in
//!   the amplitude itself, whatever the modulation's phase.
//!   Under noise of 1 % of the mean amplitude, for modulations of 1 to 50 Hz and any phase, its ends lie within 3 % of
//!   the modulation's period and 0.5 ms of the true ones (test `the_rises_found_are_those_of_the_modulation`).
//! - The *instance* is the middle 60 ms of a rising stretch, so every condition applies to those 60 ms alone.
//! - Speed is judged on its running mean over 20 ms: a differentiated encoder step is no change of the finger's
//!   velocity.

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
