//! Recording and study folders: written live so that a killed process leaves a readable recording, and read back as a
//! stream.
//!
//! A folder holds [`MANIFEST_FILE`], [`SIGNALS_FILE`], [`FORCE_FILE`] and [`POSITION_FILE`]. Sample 0 of the audio is
//! time 0; lost samples are NaN, never dropped.

mod csv_rows;
pub mod disk;
pub mod lock;
pub mod manifest;
pub mod pipeline;
mod read_error;
pub mod reader;
pub mod recorder;
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

/// File that describes the recording: its manifest.
pub const MANIFEST_FILE: &str = "recording.toml";
/// File of all audio channels as sampled.
pub const SIGNALS_FILE: &str = "signals.wav";
/// File of normal and lateral force.
pub const FORCE_FILE: &str = "force.csv";
/// File of positions along the plate.
pub const POSITION_FILE: &str = "position.csv";

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
