//! Complete simulated apparatus: plate, person and sensors behind a sound card, two serial ports and GPIO pins.
//!
//! In [`WorldPace::Stepped`](crate::world_clock::WorldPace::Stepped) one [`Apparatus::step`] advances the simulation by
//! one period, synchronously and in this order: the person acts on the latest percept, the output callback provides the
//! drive, the plant responds, the input callback receives the samples, force samples that are due become readable on
//! the serial port, the pins take their new levels. The same seed, scenario and calls give bit-identical results. In
//! [`WorldPace::RealTime`](crate::world_clock::WorldPace::RealTime) a thread does the same, in step with the machine's
//! clock.

mod apparatus_error;
mod dead_man_hand;
mod fault_panel;
mod force_side;
mod mass_set;
mod outboard;
mod patchbay;
mod rehearsal_hand;
mod senses;
mod settings;
mod simulation;
mod world;

pub use apparatus_error::ApparatusError;
pub use dead_man_hand::DeadManHand;
pub use fault_panel::FaultPanel;
pub use mass_set::MassSet;
pub use outboard::{Outboard, Timetable};
pub use patchbay::Patchbay;
pub use rehearsal_hand::RehearsalHand;
pub use senses::Senses;
pub use settings::ApparatusConfig;
pub use simulation::{Apparatus, ApparatusClock};

pub use crate::vibrometer::VibrometerAim;
