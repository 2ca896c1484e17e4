//! Numbers within an element of an HDF5 array.

use hdf5_reader::Datatype;
use hdf5_reader::datatype_api::H5Type;
use hdf5_reader::error::{ByteOrder, Error, Result};

use crate::array::Element;

/// A number in the bytes of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    Integer {
        bytes: u8,
        is_signed: bool,
        is_big_endian: bool,
    },
    Float {
        bytes: u8,
        is_big_endian: bool,
    },
}

impl Number {
    /// Returns the number of a type, and the kind of its elements; `None` for types that are no number.
    pub(crate) fn of(datatype: &Datatype) -> Option<(Self, Element)> {
        let is_big = |order: &ByteOrder| *order == ByteOrder::BigEndian;
        match datatype {
            Datatype::FixedPoint {
                size: bytes @ (1 | 2 | 4 | 8),
                signed,
                byte_order,
            } => Some(Self::integer(*bytes, *signed, is_big(byte_order))),
            Datatype::Bitfield {
                size: bytes @ (1 | 2 | 4 | 8),
                byte_order,
            } => Some(Self::integer(*bytes, false, is_big(byte_order))),
            Datatype::FloatingPoint {
                size: bytes @ (2 | 4 | 8),
                byte_order,
            } => {
                let number = Self::Float {
                    bytes: *bytes,
                    is_big_endian: is_big(byte_order),
                };
                Some((number, Element::Float { bits: bytes * 8 }))
            }
            Datatype::Enum { base, members } => {
                let (number, element) = Self::of(base)?;
                // As h5py stores booleans.
                let names = ["FALSE", "TRUE"];
                let is_logical = members.len() == 2
                    && members
                        .iter()
                        .all(|member| names.contains(&member.name.as_str()));
                Some((
                    number,
                    if is_logical {
                        Element::Logical
                    } else {
                        element
                    },
                ))
            }
            _ => None,
        }
    }

    fn integer(bytes: u8, is_signed: bool, is_big_endian: bool) -> (Self, Element) {
        let bits = bytes * 8;
        let number = Self::Integer {
            bytes,
            is_signed,
            is_big_endian,
        };
        (number, Element::Integer { bits, is_signed })
    }

    /// Returns the number of bytes.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Integer { bytes, .. } | Self::Float { bytes, .. } => usize::from(bytes),
        }
    }

    /// Returns the number that the first bytes are; `None` if they are too few.
    pub(crate) fn value(self, bytes: &[u8]) -> Option<f64> {
        let stored = bytes.get(..self.bytes())?;
        let mut ordered = [0; 8];
        for (to, from) in ordered.iter_mut().zip(stored) {
            *to = *from;
        }
        let (Self::Integer { is_big_endian, .. } | Self::Float { is_big_endian, .. }) = self;
        if is_big_endian {
            ordered.get_mut(..self.bytes())?.reverse();
        }
        let bits = u64::from_le_bytes(ordered);
        Some(match self {
            Self::Integer {
                is_signed: false, ..
            } => bits as f64,
            Self::Integer { bytes, .. } => {
                let unused = 64 - 8 * u32::from(bytes);
                ((bits << unused) as i64 >> unused) as f64
            }
            Self::Float { bytes: 2, .. } => half(bits as u16),
            Self::Float { bytes: 4, .. } => f64::from(f32::from_bits(bits as u32)),
            Self::Float { .. } => f64::from_bits(bits),
        })
    }
}

/// Returns the value of a float of 16 bits.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    }
}

/// An element that is one real number.
#[derive(Debug, Clone)]
pub(crate) struct Real(pub(crate) f64);

/// An element that is more than a number: its bytes.
#[derive(Debug, Clone)]
pub(crate) struct Bytes(pub(crate) Box<[u8]>);

fn mismatch() -> Error {
    Error::InvalidData("an element of another size".to_owned())
}

impl H5Type for Real {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], datatype: &Datatype) -> Result<Self> {
        let (number, _) = Number::of(datatype).ok_or_else(mismatch)?;
        number.value(bytes).map(Self).ok_or_else(mismatch)
    }

    fn element_size(datatype: &Datatype) -> usize {
        Number::of(datatype).map_or(0, |(number, _)| number.bytes())
    }

    fn decode_vec(raw: &[u8], datatype: &Datatype, count: usize) -> Option<Result<Vec<Self>>> {
        let (number, _) = Number::of(datatype)?;
        let raw = raw.get(..count.checked_mul(number.bytes())?)?;
        let values = raw.chunks_exact(number.bytes());
        Some(Ok(values
            .filter_map(|bytes| number.value(bytes))
            .map(Self)
            .collect()))
    }
}

impl H5Type for Bytes {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], _datatype: &Datatype) -> Result<Self> {
        Ok(Self(bytes.into()))
    }

    fn element_size(datatype: &Datatype) -> usize {
        hdf5_reader::dtype_element_size(datatype).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Number, half};

    #[test]
    fn halves_have_their_values() {
        let values = [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2f64.powi(-24)),
            (0x3555, 0.333_251_953_125),
            (0xfc00, f64::NEG_INFINITY),
        ];
        for (bits, value) in values {
            assert_eq!(half(bits), value, "{bits:x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn integers_of_each_size_and_order_have_their_values() {
        for bytes in [1_u8, 2, 4, 8] {
            for value in [-100_i64, 0, 127] {
                for is_big_endian in [false, true] {
                    let (number, _) = Number::integer(bytes, true, is_big_endian);
                    let little = value.to_le_bytes();
                    let mut stored = little[..usize::from(bytes)].to_vec();
                    if is_big_endian {
                        stored.reverse();
                    }
                    assert_eq!(number.value(&stored), Some(value as f64));
                    assert_eq!(number.value(&stored[1..]), None);
                }
            }
        }
        let (unsigned, _) = Number::integer(4, false, true);
        assert_eq!(unsigned.value(&[255; 4]), Some(f64::from(u32::MAX)));
    }
}
