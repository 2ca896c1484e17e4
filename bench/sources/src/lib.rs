//! Sources of forces, positions and stops behind one trait each, [`ForceSource`], [`position::PositionSource`] and the
//! lines of `safety`: each with its clock, its faults, and a way to say that it is silent, saturated, or has lost
//! readings.
//!
//! [`open()`] makes the source that `bench.toml` names. Nothing here knows whether the hardware is real.

mod backlog;
pub mod channels;
mod correct;
mod device_time;
pub mod field_box;
mod force_source;
mod gone;
mod lines;
pub mod netft;
mod nonsense;
mod numbering;
mod open;
pub mod position;
mod sensor_clock;
pub mod serial;

pub use force_source::{ForceSource, LineFaults, Moment, SourceHealth, TimedForce};
pub use gone::SourceGone;
pub use lines::{LineError, LineSource, Lines, take_lines};
pub use open::{Place, open, tapped};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
