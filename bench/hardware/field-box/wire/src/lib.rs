#![no_std]
#![doc = include_str!("../README.md")]

mod frame;
mod from_box;
mod listener;
mod to_box;

pub use frame::{Encoded, LONGEST_BYTES, Refused, VERSION};
pub use from_box::{BoxIdentity, FromBox, Levels, Report, StopReason};
pub use listener::{Listener, Message};
pub use to_box::{ToBox, Word};
