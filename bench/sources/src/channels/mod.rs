//! A force sensor with gauges on inputs of the sound card: the samples share the audio clock, so that neither clock alignment
//! nor frames are needed.

mod decimator;
mod fading;
mod gauge_force;
mod lowpass;
mod stuck;

pub use fading::Fading;
pub use gauge_force::GaugeForce;
