//! Recording and study folders: written live so that a killed process leaves a readable recording, and read back as a
//! stream.
//!
//! A recording folder contains [`MANIFEST_FILE`], [`SIGNALS_FILE`], [`FORCE_FILE`] and [`POSITION_FILE`]. Sample 0 of the
//! audio is time 0; lost samples are NaN, never dropped. A recording made elsewhere may have [`ENVELOPES_FILE`] in place of the
//! signals, or forces alone.

mod csv_rows;
pub mod disk;
pub mod disk_limit;
mod file_name;
pub mod lock;
pub mod manifest;
pub mod moving_pipeline;
pub mod pipeline;
mod read_error;
pub mod reader;
pub mod recorded_arrays;
mod recorded_chain;
pub mod rights;
mod row_order;
mod rows;
pub mod source;
pub mod storage;
pub mod study;
pub mod sums;
mod table_source;
pub mod writer;

pub use csv_rows::{CsvRow, ForceRow, PositionRow, StimulusRow};
pub use disk::DiskError;
pub use file_name::{FileName, file_name};
pub use manifest::Manifest;
pub use reader::RecordingReader;
pub use source::RecordingSource;
pub use table_source::table_path;
pub use wav_files::AudioFormat;
pub use writer::RecordingWriter;

/// Manifest, which describes the recording.
pub const MANIFEST_FILE: &str = "recording.toml";
/// Samples of all audio channels.
pub const SIGNALS_FILE: &str = "signals.wav";
/// Complex envelopes of drive and pickup, in place of their samples.
pub const ENVELOPES_FILE: &str = "envelopes.parquet";
/// Normal and lateral force.
pub const FORCE_FILE: &str = "force.csv";
/// Positions along the plate.
pub const POSITION_FILE: &str = "position.csv";
/// Stimulus of a surface of which only forces were recorded.
pub const STIMULUS_FILE: &str = "stimulus.csv";

/// Normal and lateral force, compressed by gzip as in an archive.
pub const COMPRESSED_FORCE_FILE: &str = "force.csv.gz";
/// Positions along the plate, compressed by gzip as in an archive.
pub const COMPRESSED_POSITION_FILE: &str = "position.csv.gz";

/// Files of a recording made elsewhere or of an archived one, in addition to [`sums::FILES`].
pub const OTHER_FILES: [&str; 4] = [
    ENVELOPES_FILE,
    STIMULUS_FILE,
    COMPRESSED_FORCE_FILE,
    COMPRESSED_POSITION_FILE,
];

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
