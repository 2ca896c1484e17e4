//! Sources of forces behind one trait, [`ForceSource`]: each with its clock, its faults, and a way to say that it is
//! silent, saturated, or has lost readings.
//!
//! [`open()`] makes the source that `bench.toml` names. Nothing here knows whether the hardware is real.

pub mod channels;
mod correct;
mod force_source;
pub mod netft;
mod nonsense;
mod open;
mod sensor_clock;
pub mod serial;

pub use force_source::{ForceSource, LineFaults, Moment, SourceGone, SourceHealth, TimedForce};
pub use open::{Place, open, tapped};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
