//! Recording and study folders: written live so that a killed process leaves a readable recording, and read back as a
//! stream.
//!
//! A recording folder contains [`MANIFEST_FILE`], [`SIGNALS_FILE`], [`FORCE_FILE`] and [`POSITION_FILE`]. Sample 0 of the
//! audio is time 0; lost samples are NaN, never dropped.

mod csv_rows;
pub mod disk;
pub mod disk_limit;
mod json_fault;
pub mod lock;
pub mod manifest;
pub mod pipeline;
mod read_error;
pub mod reader;
pub mod recorder;
pub mod rights;
mod rows;
pub mod storage;
pub mod study;
pub mod sums;
pub mod wav;
pub mod writer;

pub use csv_rows::{CsvRow, ForceRow, PositionRow};
pub use disk::DiskError;
pub use manifest::Manifest;
pub use reader::RecordingReader;
pub use wav::AudioFormat;
pub use writer::RecordingWriter;

/// Manifest, which describes the recording.
pub const MANIFEST_FILE: &str = "recording.toml";
/// Samples of all audio channels.
pub const SIGNALS_FILE: &str = "signals.wav";
/// Normal and lateral force.
pub const FORCE_FILE: &str = "force.csv";
/// Positions along the plate.
pub const POSITION_FILE: &str = "position.csv";

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
