#![no_std]
#![doc = include_str!("../README.md")]

mod guard;

pub use guard::{Guard, Order, Outputs, SILENCE_US, Stop};
