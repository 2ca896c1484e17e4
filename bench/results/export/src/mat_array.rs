//! Arrays of a Level 5 MAT-file, written in the order of their bytes.
//!
//! The format is that of "MAT-File Format" (The MathWorks, 2023), chapter 1: a header of 128 bytes, then data elements, each with a
//! tag of its type and its length in bytes, padded to a multiple of 8. Elements are not compressed, so that they can be written as
//! a stream.

use std::io::{self, Write};
use std::ops::Range;

use crate::column::ColumnValues;
use crate::fill_error::FillError;
use crate::numbers::{NumberType, write_numbers};

/// Most bytes of a variable: lengths have 32 bits, and MATLAB reads them as signed.
pub(crate) const LIMIT_BYTES: u64 = i32::MAX as u64;

/// Bytes per name of a struct's field, which ends in a zero.
const FIELD_BYTES: usize = 64;

// Types of data elements.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const SINGLE: u32 = 7;
const DOUBLE: u32 = 9;
const INT64: u32 = 12;
const MATRIX: u32 = 14;
const UTF8: u32 = 16;

/// Bytes of the tag of an element.
const TAG_BYTES: u64 = 8;

/// Array of a MAT-file.
#[derive(Debug)]
pub(crate) enum MatArray<'a> {
    /// One struct with fields.
    Struct(Vec<(String, MatArray<'a>)>),
    /// A row of characters.
    Text(String),
    /// A column of texts, as cells.
    Cells(&'a [String]),
    /// A range of the numbers of a column, as a column vector.
    Numbers(&'a ColumnValues, Range<u64>),
    /// A number.
    Real(f64),
    /// A whole number, as a double: most functions of MATLAB want doubles.
    Whole(i64),
}

impl<'a> MatArray<'a> {
    /// Returns the array of a column with this number of rows.
    pub(crate) fn column(values: &'a ColumnValues, rows: u64) -> Self {
        match values {
            ColumnValues::Text(texts) => Self::Cells(texts),
            values => Self::Numbers(values, 0..rows),
        }
    }

    /// Returns the bytes of its data element with this name, without the element's tag.
    pub(crate) fn bytes(&self, name: &str) -> u64 {
        // Flags, dimensions and name, each with a tag.
        let head = 3 * TAG_BYTES + 8 + 8 + padded(name.len() as u64);
        head + match self {
            Self::Struct(fields) => {
                let names = (fields.len() * FIELD_BYTES) as u64;
                let values = fields.iter().map(|(_, value)| TAG_BYTES + value.bytes(""));
                TAG_BYTES + TAG_BYTES + names + values.sum::<u64>()
            }
            Self::Text(text) => TAG_BYTES + padded(text.len() as u64),
            Self::Cells(texts) => {
                let cell = |text: &String| TAG_BYTES + Self::Text(text.clone()).bytes("");
                texts.iter().map(cell).sum()
            }
            Self::Numbers(values, range) => {
                let size = number_type(values).bytes();
                TAG_BYTES + padded(size * (range.end - range.start))
            }
            Self::Real(_) | Self::Whole(_) => TAG_BYTES + 8,
        }
    }

    /// Writes its data element.
    ///
    /// # Errors
    /// The file cannot be written, or a column's source cannot be read.
    pub(crate) fn write(&self, name: &str, out: &mut dyn Write) -> Result<(), FillError> {
        tag(out, MATRIX, self.bytes(name))?;
        tag(out, UINT32, 8)?;
        out.write_all(&self.class().to_le_bytes())?;
        out.write_all(&[0; 4])?;
        tag(out, INT32, 8)?;
        for length in self.dimensions() {
            out.write_all(&length.to_le_bytes())?;
        }
        element(out, INT8, name.as_bytes())?;
        match self {
            Self::Struct(fields) => {
                // Length of the names, as a short element.
                out.write_all(&((4 << 16) | INT32).to_le_bytes())?;
                out.write_all(&(FIELD_BYTES as u32).to_le_bytes())?;
                tag(out, INT8, (fields.len() * FIELD_BYTES) as u64)?;
                for (name, _) in fields {
                    let mut bytes = name.clone().into_bytes();
                    bytes.resize(FIELD_BYTES, 0);
                    out.write_all(&bytes)?;
                }
                for (_, value) in fields {
                    value.write("", out)?;
                }
            }
            Self::Text(text) => element(out, UTF8, text.as_bytes())?,
            Self::Cells(texts) => {
                for text in *texts {
                    Self::Text(text.clone()).write("", out)?;
                }
            }
            Self::Numbers(values, range) => {
                let number = number_type(values);
                let bytes = number.bytes() * (range.end - range.start);
                let kind = match number {
                    NumberType::Single => SINGLE,
                    NumberType::Double => DOUBLE,
                    NumberType::Whole => INT64,
                };
                tag(out, kind, bytes)?;
                write_numbers(values, range.clone(), out)?;
                pad(out, bytes)?;
            }
            Self::Real(value) => element(out, DOUBLE, &value.to_le_bytes())?,
            Self::Whole(value) => element(out, DOUBLE, &(*value as f64).to_le_bytes())?,
        }
        Ok(())
    }

    /// Returns the number of its class.
    fn class(&self) -> u32 {
        match self {
            Self::Cells(_) => 1,
            Self::Struct(_) => 2,
            Self::Text(_) => 4,
            Self::Real(_) | Self::Whole(_) => 6,
            Self::Numbers(values, _) => match number_type(values) {
                NumberType::Double => 6,
                NumberType::Single => 7,
                NumberType::Whole => 14,
            },
        }
    }

    fn dimensions(&self) -> [u32; 2] {
        let length = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        match self {
            Self::Struct(_) | Self::Real(_) | Self::Whole(_) => [1, 1],
            Self::Text(text) => match text.chars().count() {
                0 => [0, 0],
                n => [1, length(n)],
            },
            Self::Cells(texts) => [length(texts.len()), 1],
            Self::Numbers(_, range) => [length((range.end - range.start) as usize), 1],
        }
    }
}

/// Writes the header of a file; `text` describes it, in at most 116 ASCII characters.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_header(text: &str, out: &mut dyn Write) -> io::Result<()> {
    let mut header = text.as_bytes().to_vec();
    header.resize(116, b' ');
    header.extend([0; 8]);
    header.extend(0x0100_u16.to_le_bytes());
    header.extend(b"IM");
    out.write_all(&header)
}

/// Returns the type of a column's numbers; texts have none and are cells.
fn number_type(values: &ColumnValues) -> NumberType {
    values.number_type().unwrap_or(NumberType::Double)
}

fn padded(bytes: u64) -> u64 {
    bytes.next_multiple_of(8)
}

fn tag(out: &mut dyn Write, kind: u32, bytes: u64) -> io::Result<()> {
    let length = u32::try_from(bytes).map_err(|_| io::ErrorKind::FileTooLarge)?;
    out.write_all(&kind.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())
}

fn pad(out: &mut dyn Write, bytes: u64) -> io::Result<()> {
    out.write_all(&[0; 8][..(padded(bytes) - bytes) as usize])
}

fn element(out: &mut dyn Write, kind: u32, bytes: &[u8]) -> io::Result<()> {
    tag(out, kind, bytes.len() as u64)?;
    out.write_all(bytes)?;
    pad(out, bytes.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_those_of_the_bytes() {
        let texts = vec!["a".to_owned(), String::new(), "σ and 𝄞".to_owned()];
        let values = ColumnValues::Real(vec![1.0, f64::NAN, -3.0]);
        let whole = ColumnValues::Whole(vec![1, -2]);
        let inner = MatArray::Struct(vec![
            ("x".to_owned(), MatArray::column(&values, 3)),
            ("n".to_owned(), MatArray::column(&whole, 2)),
        ]);
        let arrays = MatArray::Struct(vec![
            ("inner".to_owned(), inner),
            ("text".to_owned(), MatArray::Text("words".to_owned())),
            ("empty".to_owned(), MatArray::Text(String::new())),
            ("cells".to_owned(), MatArray::Cells(&texts)),
            ("real".to_owned(), MatArray::Real(2.5)),
            ("whole".to_owned(), MatArray::Whole(-7)),
            ("part".to_owned(), MatArray::Numbers(&values, 1..2)),
            ("nothing".to_owned(), MatArray::Struct(Vec::new())),
        ]);
        for name in ["", "recording", "eight_by"] {
            let mut bytes = Vec::new();
            arrays.write(name, &mut bytes).unwrap();
            assert_eq!(bytes.len() as u64, TAG_BYTES + arrays.bytes(name), "{name}");
            let length = u32::from_le_bytes(bytes[4..8].try_into().unwrap());
            assert_eq!(u64::from(length), arrays.bytes(name));
        }
    }

    #[test]
    fn a_header_has_128_bytes() {
        let mut bytes = Vec::new();
        write_header("MATLAB 5.0 MAT-file", &mut bytes).unwrap();
        assert_eq!(bytes.len(), 128);
        assert_eq!(&bytes[124..], [0, 1, b'I', b'M']);
    }
}
