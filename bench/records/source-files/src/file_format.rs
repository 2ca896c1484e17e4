//! Formats of files.

use std::fmt;

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MATLAB v4.
    Matlab4,
    /// MATLAB v5 or v6, without compression.
    Matlab5,
    /// MATLAB v7, with compression.
    Matlab7,
    /// MATLAB v7.3, within HDF5.
    Matlab73,
    /// HDF5.
    Hdf5,
    /// TDMS of National Instruments.
    Tdms,
    /// One array of NumPy.
    Npy,
    /// Archive of NumPy's arrays.
    Npz,
    /// WAV.
    Wav,
    /// RF64.
    Rf64,
    /// BW64.
    Bw64,
    /// Wave64 of Sony.
    Wave64,
    /// FLAC.
    Flac,
    /// Measurement file of LabVIEW.
    Lvm,
    /// Table as text.
    Text,
    /// Parquet.
    Parquet,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 16] = [
        Self::Matlab4,
        Self::Matlab5,
        Self::Matlab7,
        Self::Matlab73,
        Self::Hdf5,
        Self::Tdms,
        Self::Npy,
        Self::Npz,
        Self::Wav,
        Self::Rf64,
        Self::Bw64,
        Self::Wave64,
        Self::Flac,
        Self::Lvm,
        Self::Text,
        Self::Parquet,
    ];

    /// Returns the reader and its version.
    #[must_use]
    pub fn reader(self) -> &'static str {
        match self {
            Self::Npy | Self::Npz => "npyz 0.9.1",
            Self::Flac => "symphonia 0.6.1",
            Self::Parquet => "parquet 60.1.0",
            Self::Matlab73 | Self::Hdf5 => "hdf5-reader 0.12.1",
            _ => concat!("friction-bench ", env!("CARGO_PKG_VERSION")),
        }
    }

    /// Returns whether the arrays are columns of one table, which numbers name too.
    pub(crate) fn is_table(self) -> bool {
        matches!(self, Self::Lvm | Self::Text | Self::Parquet)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Matlab4 => "MATLAB v4",
            Self::Matlab5 => "MATLAB v5",
            Self::Matlab7 => "MATLAB v7",
            Self::Matlab73 => "MATLAB v7.3",
            Self::Hdf5 => "HDF5",
            Self::Tdms => "TDMS",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
            Self::Wav => "WAV",
            Self::Rf64 => "RF64",
            Self::Bw64 => "BW64",
            Self::Wave64 => "Wave64",
            Self::Flac => "FLAC",
            Self::Lvm => "LVM",
            Self::Text => "text",
            Self::Parquet => "Parquet",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_are_named_with_the_versions_in_use() {
        let lock = include_str!("../../../../Cargo.lock");
        for format in Format::ALL {
            let (name, version) = format.reader().split_once(' ').unwrap();
            let entry = format!("name = \"{name}\"\nversion = \"{version}\"");
            assert!(lock.contains(&entry), "{format}: {name} {version}");
        }
    }
}
