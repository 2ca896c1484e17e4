//! Exports a study to other formats: the streams of each recording, its constants, and its friction over time.
//!
//! | format | files | opened by |
//! | --- | --- | --- |
//! | `mat` | one Level 5 MAT-file per recording | MATLAB, Octave, scipy |
//! | `npz` | one archive of arrays per recording | numpy |
//! | `csv` | a folder of tables per recording, and `columns.csv` | any program |
//! | `bids` | one dataset of the Brain Imaging Data Structure | programs for BIDS |
//!
//! [`export`] writes them. Streams are read and written in blocks, so that memory does not depend on a recording's length, except for
//! its analysis. A quantity has its SI unit in its name, in every format.

mod bids;
mod column;
mod constants;
mod content;
mod csv_tables;
mod decimal;
mod dictionary;
mod export_error;
mod export_format;
mod export_origin;
mod fill_error;
mod friction;
mod identity;
mod marks;
mod mat;
mod mat_array;
mod npz;
mod numbers;
mod recorded_tables;
mod stream;
mod study_export;
mod target_folder;

pub use export_error::ExportError;
pub use export_format::ExportFormat;
pub use export_origin::ExportOrigin;
pub use study_export::{ExportOptions, ExportSummary, ExportedFiles, ExportedRecording, export};
pub use target_folder::FileState;
