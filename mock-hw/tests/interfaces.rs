//! Tests of the simulated apparatus through its interfaces: cpal, a serial port and embedded-hal pins.
//!
//! Without pseudo-terminals in the operating system, only sound cards and pins are tested.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

#[cfg(unix)]
#[path = "interfaces/force_line.rs"]
mod force_line;
#[cfg(unix)]
#[path = "interfaces/known_masses.rs"]
mod known_masses;
#[path = "interfaces/pins.rs"]
mod pins;
#[path = "interfaces/sound_card.rs"]
mod sound_card;
#[path = "interfaces/streams.rs"]
mod streams;
#[cfg(unix)]
#[path = "interfaces/vibrometer.rs"]
mod vibrometer;
#[cfg(unix)]
#[path = "interfaces/world.rs"]
mod world;
