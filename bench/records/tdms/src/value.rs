//! Types of samples and properties.

use std::fmt;

use crate::bytes::Bytes;

/// Type of a channel's samples in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named by their sizes")]
pub enum SampleType {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
    Boolean,
    /// Text; not read as samples.
    Text,
    /// Seconds since 1904 with a fraction, 16 bytes; read as seconds since 1904-01-01 UTC.
    Timestamp,
    /// Real and imaginary part, `f32`.
    Complex64,
    /// Real and imaginary part, `f64`.
    Complex128,
    /// Buffers of a DAQmx task.
    Daqmx,
    /// A type that the note does not define, or of which no size is known.
    Other(u32),
    /// A type of a DAQmx task that is not known.
    OtherOfDaqmx(u32),
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text => f.write_str("text"),
            Self::Boolean => f.write_str("true or false"),
            Self::Timestamp => f.write_str("times"),
            Self::Complex64 => f.write_str("complex f32"),
            Self::Complex128 => f.write_str("complex f64"),
            Self::Daqmx => f.write_str("buffers of a DAQmx task"),
            Self::Other(code) => write!(f, "an unknown type (0x{code:x})"),
            Self::OtherOfDaqmx(code) => write!(f, "an unknown DAQmx type ({code})"),
            Self::I8 => f.write_str("i8"),
            Self::I16 => f.write_str("i16"),
            Self::I32 => f.write_str("i32"),
            Self::I64 => f.write_str("i64"),
            Self::U8 => f.write_str("u8"),
            Self::U16 => f.write_str("u16"),
            Self::U32 => f.write_str("u32"),
            Self::U64 => f.write_str("u64"),
            Self::F32 => f.write_str("f32"),
            Self::F64 => f.write_str("f64"),
        }
    }
}

impl SampleType {
    /// Reads a type's code.
    pub(crate) fn from_code(code: u32) -> Self {
        match code {
            0x01 => Self::I8,
            0x02 => Self::I16,
            0x03 => Self::I32,
            0x04 => Self::I64,
            0x05 => Self::U8,
            0x06 => Self::U16,
            0x07 => Self::U32,
            0x08 => Self::U64,
            // With a unit, which stands in the properties.
            0x09 | 0x19 => Self::F32,
            0x0a | 0x1a => Self::F64,
            0x20 => Self::Text,
            0x21 => Self::Boolean,
            0x44 => Self::Timestamp,
            0x0008_000c => Self::Complex64,
            0x0010_000d => Self::Complex128,
            0xffff_ffff => Self::Daqmx,
            other => Self::Other(other),
        }
    }

    /// Returns the size of a sample, bytes; `None` where it varies or is unknown.
    pub(crate) fn size(self) -> Option<u64> {
        match self {
            Self::I8 | Self::U8 | Self::Boolean => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 | Self::F32 => Some(4),
            Self::I64 | Self::U64 | Self::F64 | Self::Complex64 => Some(8),
            Self::Timestamp | Self::Complex128 => Some(16),
            Self::Text | Self::Daqmx | Self::Other(_) | Self::OtherOfDaqmx(_) => None,
        }
    }

    /// Returns whether samples have an imaginary part.
    pub(crate) fn is_complex(self) -> bool {
        matches!(self, Self::Complex64 | Self::Complex128)
    }

    /// Returns a sample's real and imaginary part; `None` for types that are no number.
    pub(crate) fn complex(self, bytes: &[u8], is_big_endian: bool) -> Option<[f64; 2]> {
        let (part, size) = match self {
            Self::Complex64 => (Self::F32, 4),
            Self::Complex128 => (Self::F64, 8),
            real => return real.number(bytes, is_big_endian).map(|re| [re, 0.0]),
        };
        let re = part.number(bytes, is_big_endian)?;
        let im = part.number(bytes.get(size..)?, is_big_endian)?;
        Some([re, im])
    }

    /// Returns a sample as a real number; `None` for types that are no real number.
    pub(crate) fn number(self, bytes: &[u8], is_big_endian: bool) -> Option<f64> {
        let mut bytes = Bytes::new(bytes, is_big_endian);
        Some(match self {
            Self::I8 => f64::from(bytes.array::<1>().map(i8::from_ne_bytes)?),
            Self::U8 | Self::Boolean => f64::from(bytes.array::<1>().map(u8::from_ne_bytes)?),
            Self::I16 => f64::from(bytes.ordered().map(i16::from_le_bytes)?),
            Self::U16 => f64::from(bytes.ordered().map(u16::from_le_bytes)?),
            Self::I32 => f64::from(bytes.ordered().map(i32::from_le_bytes)?),
            Self::U32 => f64::from(bytes.ordered().map(u32::from_le_bytes)?),
            Self::I64 => bytes.ordered().map(i64::from_le_bytes)? as f64,
            Self::U64 => bytes.ordered().map(u64::from_le_bytes)? as f64,
            Self::F32 => f64::from(bytes.ordered().map(f32::from_le_bytes)?),
            Self::F64 => bytes.ordered().map(f64::from_le_bytes)?,
            Self::Timestamp => bytes.timestamp()?,
            Self::Text
            | Self::Complex64
            | Self::Complex128
            | Self::Daqmx
            | Self::Other(_)
            | Self::OtherOfDaqmx(_) => return None,
        })
    }
}

/// Value of a property.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Any number, or seconds since 1904-01-01 UTC.
    Number(f64),
    /// Text.
    Text(String),
}

impl Value {
    /// Returns a number.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(_) => None,
        }
    }

    /// Returns text.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Number(_) => None,
            Self::Text(text) => Some(text),
        }
    }

    /// Reads a value of a type; `None` if the bytes end, or the type is unknown.
    pub(crate) fn read(sample_type: SampleType, bytes: &mut Bytes<'_>) -> Option<Self> {
        if sample_type == SampleType::Text {
            return bytes.text().map(Self::Text);
        }
        let size = sample_type.size()?;
        let is_big_endian = bytes.is_big_endian();
        let value = bytes.take(size)?;
        match sample_type {
            SampleType::Complex64 | SampleType::Complex128 => {
                Some(Self::Text("a complex number".to_owned()))
            }
            _ => sample_type.number(value, is_big_endian).map(Self::Number),
        }
    }
}
