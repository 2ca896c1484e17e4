//! `calibrate channels`: the same signal on all inputs gives each input's gain, delay and linearity relative to the drive's
//! input, its noise, the drive's crosstalk into it, and the loss of the carrier on the way from the generator.
//!
//! A scan with faint tones below the safety watch's floor comes first: it detects silent, swapped and saturated inputs, and
//! resampling sound layers, before any louder tone is played.

mod channels_procedure;
mod channels_setup;
mod channels_verdict;
mod compare;
mod faint_look;
mod fault;
mod input_noise;
mod ladder;
mod silence;
mod tone_ratios;

pub use channels_procedure::ChannelsProcedure;
pub use channels_setup::{ChannelsSetup, LoopDelays, OPENINGS};
pub use compare::{Present, compare};
pub use fault::ChannelsFault;
