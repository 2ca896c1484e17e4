//! The force sensor's serial line: two formats (`docs/force-protocol.md`), one stream of samples on the host's clock.

mod device_time;
mod force_sample;
mod frames;
mod link;
mod nonsense;
mod text_lines;

pub use force_sample::{Decoder, ForceSample, LineFaults};
pub use frames::FrameDecoder;
pub use link::{ForceLink, ForcePort, TimedForce, decoder, open_port};
pub use text_lines::LineDecoder;
