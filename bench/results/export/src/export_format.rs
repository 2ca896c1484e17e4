//! Formats of an export.

use clap::ValueEnum;

/// Format of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// MATLAB Level 5, one file per recording, for MATLAB, Octave and scipy.
    Mat,
    /// NumPy arrays, one archive per recording.
    Npz,
    /// Tables of text, one folder per recording, and a dictionary of their columns.
    Csv,
    /// One dataset of the Brain Imaging Data Structure, to share.
    Bids,
}
