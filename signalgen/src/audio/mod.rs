//! The sound card: hosts, devices, and the two streams that call the [`crate::DriveRenderer`] and the [`crate::InputWriter`].
//! Only files of this folder use `cpal`.
//!
//! cpal 0.18 has no packed 24-bit samples (ALSA S24_3LE and similar). A card that offers no other format is refused with
//! [`AudioError::NoUsableFormat`]; a JACK server that runs on the card is the workaround.

mod audio_error;
mod audio_host;
mod callbacks;
mod card_holder;
mod card_sample;
mod choice;
mod device_list;
mod duplex;
mod quiet;
mod sound_device;

pub use audio_error::AudioError;
pub use audio_host::{HostChoice, open_host};
pub use callbacks::ThreadStart;
pub use choice::ChoiceError;
pub use cpal::{Device, Host};
pub use device_list::{list_devices, output_device};
pub use duplex::{DEFAULT_RING_S, Duplex, DuplexConfig, StreamChoice, Streams, open_duplex};
pub use sound_device::{Capability, DeviceInfo, Offer, RateRange};
