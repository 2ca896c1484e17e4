//! The trait by which each format is read.

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;

use crate::array::{ArrayInfo, Attribute};
use crate::error::SourceError;
pub(crate) use crate::file_format::Format;
pub(crate) use crate::place::{Place, strides};

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

    /// Returns the refusal of the first cell of a column of texts that is no number among numbers.
    ///
    /// # Errors
    /// The file cannot be read.
    fn first_text(&self, _index: usize) -> Result<Option<SourceError>, SourceError> {
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
