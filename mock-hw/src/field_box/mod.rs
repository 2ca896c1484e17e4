//! A field box: its firmware's guard on the apparatus's lines, behind a codec of its own.

mod codec;
mod device;

pub(crate) use device::FieldBox;
