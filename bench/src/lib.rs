//! Library of the test bench controller: devices, pipeline, recorder, analysis. The binary composes it with hardware,
//! real or simulated; nothing in here knows which.

pub mod acquisition;
pub mod analysis;
pub mod analyze;
pub mod assembly;
pub mod calibration;
pub mod check;
pub mod cli;
pub mod clock;
pub mod config;
pub mod devices;
pub mod drive;
pub mod encoder;
pub mod field;
pub mod figures;
pub mod force;
pub mod front;
pub mod gap;
pub mod gpio;
pub mod health;
pub mod journal;
pub mod live;
pub mod model;
pub mod monitor;
pub mod pipeline;
pub mod readiness;
pub mod recording;
pub mod refit;
pub mod run;
pub mod safety;
pub mod schedule;
pub mod screen;
pub mod session;
pub mod shared;
pub mod sound;
pub mod study;
