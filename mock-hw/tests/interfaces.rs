//! The simulated apparatus seen from outside: through cpal, a serial port and embedded-hal pins.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

#[path = "interfaces/audio.rs"]
mod audio;
#[path = "interfaces/bench.rs"]
mod bench;
#[path = "interfaces/force.rs"]
mod force;
#[path = "interfaces/masses.rs"]
mod masses;
#[path = "interfaces/pins.rs"]
mod pins;
#[path = "interfaces/vibrometer.rs"]
mod vibrometer;
#[path = "interfaces/world.rs"]
mod world;
