//! Numbers of a column as bytes, least significant first: the data of arrays in MAT-files and NPY.

use std::io::Write;
use std::ops::Range;

use crate::column::ColumnValues;
use crate::fill_error::FillError;

/// Type of a number in an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    /// 32-bit float.
    Single,
    /// 64-bit float.
    Double,
    /// 64-bit whole number.
    Whole,
}

impl NumberType {
    /// Returns its size, bytes.
    pub(crate) fn bytes(self) -> u64 {
        match self {
            Self::Single => 4,
            Self::Double | Self::Whole => 8,
        }
    }
}

impl ColumnValues {
    /// Returns the type of its numbers; `None` for texts.
    pub(crate) fn number_type(&self) -> Option<NumberType> {
        match self {
            Self::Stream(stream) if stream.is_single() => Some(NumberType::Single),
            Self::Stream(_) | Self::Real(_) => Some(NumberType::Double),
            Self::Whole(_) => Some(NumberType::Whole),
            Self::Text(_) => None,
        }
    }
}

/// Writes the numbers of `range`; texts have none.
pub(crate) fn write_numbers(
    values: &ColumnValues,
    range: Range<u64>,
    out: &mut dyn Write,
) -> Result<(), FillError> {
    let indices = range.start as usize..range.end as usize;
    let mut bytes = Vec::new();
    match values {
        ColumnValues::Text(_) => {}
        ColumnValues::Whole(values) => {
            for value in values.get(indices).ok_or(FillError::Changed)? {
                bytes.extend(value.to_le_bytes());
            }
            out.write_all(&bytes)?;
        }
        ColumnValues::Real(values) => {
            for value in values.get(indices).ok_or(FillError::Changed)? {
                bytes.extend(value.to_le_bytes());
            }
            out.write_all(&bytes)?;
        }
        ColumnValues::Stream(stream) => {
            let mut source = stream.open()?;
            let (mut block, mut place) = (Vec::new(), 0);
            while place < range.end {
                source.read(&mut block)?;
                if block.is_empty() {
                    return Err(FillError::Changed);
                }
                let end = place + block.len() as u64;
                let offset = |index: u64| (index.clamp(place, end) - place) as usize;
                let wanted = &block[offset(range.start)..offset(range.end)];
                bytes.clear();
                for value in wanted {
                    match stream.is_single() {
                        true => bytes.extend((*value as f32).to_le_bytes()),
                        false => bytes.extend(value.to_le_bytes()),
                    }
                }
                out.write_all(&bytes)?;
                place = end;
            }
        }
    }
    Ok(())
}
