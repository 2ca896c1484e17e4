//! Sources of forces, positions and stops behind one trait each: [`ForceSource`], [`position::PositionSource`] and the lines of
//! `safety`. Each reports its clock, its faults, and whether it is silent, saturated, or has lost readings.
//!
//! [`open()`] creates the source that `bench.toml` names. The sources are the same for real and simulated hardware.

mod backlog;
pub mod channels;
mod correct;
mod device_time;
pub mod field_box;
mod force_source;
mod lines;
mod loss;
pub mod netft;
mod nonsense;
mod numbering;
mod open;
mod pace;
pub mod position;
mod sensor_clock;
pub mod serial;

pub use force_source::{ForceSource, LineFaults, Moment, SourceHealth, TimedForce};
pub use lines::{LineError, LineSource, Lines, take_lines};
pub use loss::SourceGone;
pub use open::{Place, open, tapped};
pub use pace::clock_cause;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
