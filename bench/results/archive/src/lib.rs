//! Archives recordings: complex envelopes of drive and pickup in place of their samples, and compressed forces and positions.
//!
//! An archive of a study is a study: `analyze`, `verify`, `export` and `list` read it. What only the samples show is checked before,
//! and its warnings stay in `[origin.archived]` of `recording.toml`. No original is changed or removed.

mod archive_error;
mod archive_folder;
mod compressed_rows;
mod envelopes;
mod places;
mod recording_archive;
mod rounding;
mod study_archive;
mod study_files;

pub use archive_error::ArchiveError;
pub use recording_archive::{ArchivedRecording, RecordingState};
pub use study_archive::{ArchiveOptions, ArchiveSummary, archive};
