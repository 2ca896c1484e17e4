//! Tests of the simulated apparatus through its interfaces: cpal, a serial port and embedded-hal pins.
//!
//! Without pseudo-terminals in the operating system, only sound cards and pins are tested.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

#[cfg(unix)]
mod force_line;
#[cfg(unix)]
mod known_masses;
mod pins;
mod sound_card;
mod streams;
#[cfg(unix)]
mod vibrometer;
#[cfg(unix)]
mod world;
