//! The simulated apparatus seen from outside: through cpal, a serial port and embedded-hal pins.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

#[path = "interfaces/force_line.rs"]
mod force_line;
#[path = "interfaces/known_masses.rs"]
mod known_masses;
#[path = "interfaces/pins.rs"]
mod pins;
#[path = "interfaces/sound_card.rs"]
mod sound_card;
#[path = "interfaces/streams.rs"]
mod streams;
#[path = "interfaces/vibrometer.rs"]
mod vibrometer;
#[path = "interfaces/world.rs"]
mod world;
