//! The field box: a device on a serial port that reads forces, position and lines, and can stop the amplifier on its own
//! (`docs/field-box-protocol.md`).

mod box_force;
mod box_lines;
mod box_position;
mod device;
mod link;
mod loss;
mod reader;
mod writer;

pub use device::FieldBoxDevice;
pub use loss::FieldBoxGone;
