//! The force sensor's serial line: two formats (`docs/force-protocol.md`), one stream of samples on the audio clock.

mod device_time;
mod frames;
mod lines;
mod link;
mod sample;

pub use frames::FrameDecoder;
pub use lines::LineDecoder;
pub use link::{ForceLink, ForcePort, TimedForce, decoder, open_port};
pub use sample::{Decoder, ForceSample, LineFaults};
