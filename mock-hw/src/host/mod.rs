//! The simulated sound cards, as a cpal host.
//!
//! There are two devices: `sim`, the bench's converter with both directions on one sample clock, and `sim-speakers`, an
//! ordinary output for cue sounds that discards what it plays. Each period the simulation takes from the output stream,
//! lets the plant answer and gives to the input stream. Callbacks run on the thread that advances the simulation, as a
//! real backend's run on the backend's thread.

mod cpal_device;
mod sound_cards;
mod stream;

pub(crate) use cpal_device::cpal_host;
pub use cpal_device::{Device, Host, Stream};
pub(crate) use sound_cards::SoundCards;
pub use sound_cards::{
    BENCH_ID, BENCH_OUTPUTS, BENCH_RATES_HZ, Direction, SPEAKERS_ID, SPEAKERS_RATE_HZ,
};
