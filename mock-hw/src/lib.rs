//! Simulated apparatus behind the real hardware interfaces.

pub mod apparatus;
pub mod clock;
pub mod fingertip;
pub mod host;
pub mod person;
pub mod pins;
pub mod plant;
pub mod scenario;
mod seed;
pub mod serial;
mod sound_layer;
pub mod truth;
mod vibrometer;
