//! Formats, and the trait by which each is read.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use num_complex::Complex64;

use crate::array::{ArrayInfo, Attribute};
use crate::error::SourceError;

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
    /// Table as text.
    Text,
    /// Parquet.
    Parquet,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 15] = [
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
        matches!(self, Self::Text | Self::Parquet)
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
            Self::Text => "text",
            Self::Parquet => "Parquet",
        })
    }
}

/// Place of a vector in an array.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Place {
    /// Axis along which it runs.
    pub(crate) axis: usize,
    /// Index on each of the other axes, in their order.
    pub(crate) fixed: Vec<u64>,
}

impl Place {
    /// Returns the offset of the first element and the distance between elements, from the distances along each axis.
    pub(crate) fn offset_and_step(&self, strides: &[u64]) -> (u64, u64) {
        let mut fixed = self.fixed.iter();
        let (mut offset, mut step) = (0u64, 0);
        for (axis, stride) in strides.iter().enumerate() {
            if axis == self.axis {
                step = *stride;
            } else {
                let index = fixed.next().copied().unwrap_or(0);
                offset = offset.saturating_add(index.saturating_mul(*stride));
            }
        }
        (offset, step)
    }
}

/// Returns the distances between elements of `item` bytes along each axis of an array.
pub(crate) fn strides(shape: &[u64], item: u64, is_column_major: bool) -> Vec<u64> {
    let mut strides = vec![0; shape.len()];
    let mut stride = item;
    for i in 0..shape.len() {
        let axis = if is_column_major {
            i
        } else {
            shape.len() - 1 - i
        };
        strides[axis] = stride;
        stride = stride.saturating_mul(shape[axis]);
    }
    strides
}

/// Values that a reader appends to.
pub(crate) enum Values<'a> {
    /// Real values.
    Real(&'a mut Vec<f64>),
    /// Complex values.
    Complex(&'a mut Vec<Complex64>),
}

impl Values<'_> {
    /// Appends a real value.
    pub(crate) fn push(&mut self, value: f64) {
        match self {
            Self::Real(values) => values.push(value),
            Self::Complex(values) => values.push(Complex64::new(value, 0.0)),
        }
    }

    /// Appends a complex value; only its real part to real values.
    pub(crate) fn push_complex(&mut self, value: Complex64) {
        match self {
            Self::Real(values) => values.push(value.re),
            Self::Complex(values) => values.push(value),
        }
    }

    /// Returns the number of values.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Complex(values) => values.len(),
        }
    }
}

/// Reader of one format.
pub(crate) trait ArrayReader: Send {
    /// Returns the format.
    fn format(&self) -> Format;

    /// Returns the arrays, in the order of the file.
    fn arrays(&self) -> &[ArrayInfo];

    /// Returns the attributes, by names as `/g/x@fs`.
    fn attributes(&self) -> &BTreeMap<String, Attribute>;

    /// Returns the sampling rate that the file states for all its arrays, Hz.
    fn stated_rate_hz(&self) -> Option<f64> {
        None
    }

    /// Returns sentences for a user about the content.
    fn notes(&self) -> &[String] {
        &[]
    }

    /// Returns the text of the array `index`, where its elements are texts and it is short.
    ///
    /// # Errors
    /// The file cannot be read there.
    fn text(&mut self, _index: usize) -> Result<Option<String>, SourceError> {
        Ok(None)
    }

    /// Appends the elements `range` along the place's axis of the array `index`.
    ///
    /// The range is within the array, and the array numeric.
    ///
    /// # Errors
    /// The file cannot be read there.
    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError>;
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

    #[test]
    fn elements_lie_by_rows_or_by_columns() {
        let shape = [2, 3, 4];
        assert_eq!(strides(&shape, 8, false), [96, 32, 8]);
        assert_eq!(strides(&shape, 8, true), [8, 16, 48]);
        let place = Place {
            axis: 1,
            fixed: vec![1, 3],
        };
        assert_eq!(place.offset_and_step(&[96, 32, 8]), (120, 32));
    }
}
