//! The devices of a bench behind one assembly: sound card, force sensor, encoder, digital lines, loudspeaker.
//!
//! [`Hardware`] is what the composition root found or simulated; [`Bench::open`] wires it into tasks, and its [`Life`] runs
//! them. Nothing here knows whether the hardware is real.

pub mod acquisition;
mod assembly;
pub mod claim;
pub mod drive;
pub mod encoder;
pub mod field;
pub mod flags;
pub mod force;
mod gauges;
mod life;
mod lines;
pub mod loss;
pub mod sound;

pub use assembly::{Bench, Hardware, OpenHardware, impedance_chain};
pub use gauges::{FieldHealth, Gauges};
pub use life::{Life, stop_on_signals};
pub use lines::Lines;
