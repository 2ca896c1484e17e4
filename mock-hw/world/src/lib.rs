#![doc = include_str!("../README.md")]

pub mod fingertip;
pub mod person;
pub mod plant;
pub mod run_truth;
pub mod scenario;
pub mod seed;
pub mod trial;
