//! A force sensor whose gauges are on inputs of the sound card: on the audio clock sample by sample, with no clock to
//! align and no frame to lose.

mod decimator;
mod fading;
mod gauge_force;
mod lowpass;
mod stuck;

pub use fading::Fading;
pub use gauge_force::GaugeForce;
