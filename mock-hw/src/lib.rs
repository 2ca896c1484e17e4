#![doc = include_str!("../README.md")]

pub mod apparatus;
mod fault_count;
mod field_box;
pub mod host;
mod network;
pub mod oscilloscope;
pub mod pins;
pub mod rack;
pub mod serial;
mod sound_layer;
mod vibrometer;
mod voltmeter;
pub mod world_clock;
