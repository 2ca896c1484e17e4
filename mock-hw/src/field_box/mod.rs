//! A field box: the guard of its firmware on the apparatus's lines, behind an independent codec.

mod codec;
mod device;
mod unloaded_box;

pub(crate) use device::FieldBox;
pub(crate) use unloaded_box::UnloadedBox;
