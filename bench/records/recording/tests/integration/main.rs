//! Recordings and studies on a real file system.
#![expect(clippy::unwrap_used, reason = "helpers of tests may fail a test")]

mod damage;
mod files;
mod limits;
mod other_writers;
#[cfg(unix)]
mod process;
mod study;
mod support;
