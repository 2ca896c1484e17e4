//! A force sensor with gauges on inputs of the sound card: its samples share the audio clock, which avoids the alignment of
//! clocks and the loss of messages.

mod decimator;
mod fading;
mod gauge_force;
mod lowpass;
mod stuck;

pub use fading::Fading;
pub use gauge_force::GaugeForce;
