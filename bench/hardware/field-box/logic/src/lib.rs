#![no_std]
#![doc = include_str!("../README.md")]

mod guard;

pub use guard::{Guard, LineRequest, Outputs, SILENCE_US, StopCause};
