//! Files of other programs through the public interface.
#![expect(clippy::unwrap_used, reason = "helpers of tests may fail a test")]

mod byte_by_byte;
mod damaged;
mod hierarchies;
#[cfg(target_os = "linux")]
mod long_files;
mod other_programs;
mod tables;
