//! The force sensor's serial line: two formats (`docs/force-protocol.md`), one stream of samples on the audio clock.

mod device_time;
mod frames;
mod text_lines;
mod link;
mod force_sample;

pub use frames::FrameDecoder;
pub use text_lines::LineDecoder;
pub use link::{ForceLink, ForcePort, TimedForce, decoder, open_port};
pub use force_sample::{Decoder, ForceSample, LineFaults};
