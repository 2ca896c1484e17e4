//! `calibrate channels`: the same signal into every input. What each makes of it, how it differs from the drive's, how much of
//! the drive leaks into it, and what the way from the generator does to the carrier.
//!
//! A faint look comes first, below what the safety watch acts on: silent, swapped, saturated inputs and sound layers that
//! resample are named before anything louder is played.

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
pub use channels_setup::ChannelsSetup;
pub use compare::{Present, compare};
pub use fault::ChannelsFault;
