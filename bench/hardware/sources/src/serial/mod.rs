//! The force sensor on a serial line: two formats (`docs/force-protocol.md`).

mod decoder;
mod frames;
mod port;
pub(crate) mod serial_force;
mod text_lines;

pub use crate::device_time::ExpectedCount;
pub use decoder::{Decoder, ForceSample};
pub use frames::FrameDecoder;
pub use port::{ForcePort, open_port};
pub(crate) use port::{MOST_BYTES, Speaking, split_port};
pub use serial_force::{SerialForce, decoder};
pub use text_lines::LineDecoder;
