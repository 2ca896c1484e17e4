//! A field box: its firmware's guard on the apparatus's lines, behind a codec of its own.

mod codec;
mod device;
mod unloaded_box;

pub(crate) use device::FieldBox;
pub(crate) use unloaded_box::UnloadedBox;
