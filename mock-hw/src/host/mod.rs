//! Simulated sound cards, as a cpal host.
//!
//! There are two devices: `sim`, the bench's converter with both directions on one sample clock, and `sim-speakers`, an
//! ordinary output for cue sounds that discards its samples. In each period the simulation takes samples from the output
//! stream, computes the plant's response and passes it to the input stream. Callbacks run on the thread that advances the
//! simulation, as those of a real backend run on the backend's thread.

mod cpal_device;
mod sound_cards;
mod stream;

pub(crate) use cpal_device::cpal_host;
pub use cpal_device::{Device, Host, Stream};
pub(crate) use sound_cards::SoundCards;
pub use sound_cards::{
    BENCH_ID, BENCH_OUTPUTS, BENCH_RATES_HZ, ConverterDirection, SPEAKERS_ID, SPEAKERS_RATE_HZ,
};
