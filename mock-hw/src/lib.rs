#![doc = include_str!("../README.md")]

pub mod apparatus;
pub mod fingertip;
pub mod host;
pub mod person;
pub mod pins;
pub mod plant;
pub mod run_truth;
pub mod scenario;
mod seed;
pub mod serial;
mod sound_layer;
mod vibrometer;
mod voltmeter;
pub mod world_clock;
