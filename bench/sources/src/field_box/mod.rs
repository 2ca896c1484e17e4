//! The field box: forces, position and lines by one device on a serial port, which stops the amplifier by itself
//! (`docs/field-box-protocol.md`).

mod box_force;
mod box_lines;
mod box_position;
mod device;
mod gone;
mod link;
mod reader;
mod writer;

pub use device::FieldBox;
pub use gone::FieldBoxGone;
