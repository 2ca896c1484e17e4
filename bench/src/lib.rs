//! Library of the test bench controller.

pub mod recording;
