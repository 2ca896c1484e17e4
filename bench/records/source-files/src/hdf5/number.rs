//! Numbers within an element of an HDF5 array.

use hdf5_reader::Datatype;
use hdf5_reader::datatype_api::H5Type;
use hdf5_reader::error::{ByteOrder, Error, Result};

use crate::array::Element;
use crate::numbers::{Encoding, NumberType};

/// Returns the encoding of a type, and the kind of its elements; `None` for types that are no number.
pub(crate) fn encoding(datatype: &Datatype) -> Option<(Encoding, Element)> {
    let (number, byte_order) = match datatype {
        Datatype::FixedPoint {
            size,
            signed,
            byte_order,
        } => (integer(*size, *signed)?, *byte_order),
        Datatype::Bitfield { size, byte_order } => (integer(*size, false)?, *byte_order),
        Datatype::FloatingPoint { size, byte_order } => {
            let number = match size {
                2 => NumberType::F16,
                4 => NumberType::F32,
                8 => NumberType::F64,
                _ => return None,
            };
            (number, *byte_order)
        }
        Datatype::Enum { base, members } => {
            let (encoding, element) = encoding(base)?;
            // As h5py stores booleans.
            let names = ["FALSE", "TRUE"];
            let mut members = members.iter();
            let is_logical =
                members.len() == 2 && members.all(|member| names.contains(&member.name.as_str()));
            return Some((
                encoding,
                if is_logical {
                    Element::Logical
                } else {
                    element
                },
            ));
        }
        _ => return None,
    };
    let encoding = Encoding {
        number,
        is_big_endian: byte_order == ByteOrder::BigEndian,
    };
    Some((encoding, number.element(false)))
}

fn integer(bytes: u8, is_signed: bool) -> Option<NumberType> {
    Some(match (bytes, is_signed) {
        (1, true) => NumberType::I8,
        (1, false) => NumberType::U8,
        (2, true) => NumberType::I16,
        (2, false) => NumberType::U16,
        (4, true) => NumberType::I32,
        (4, false) => NumberType::U32,
        (8, true) => NumberType::I64,
        (8, false) => NumberType::U64,
        _ => return None,
    })
}

/// Returns the number at the start of `bytes`; `None` if they are too few.
pub(crate) fn value(encoding: Encoding, bytes: &[u8]) -> Option<f64> {
    let bytes = bytes.get(..encoding.number.bytes())?;
    Some(encoding.decode(bytes))
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
        let (encoding, _) = encoding(datatype).ok_or_else(mismatch)?;
        value(encoding, bytes).map(Self).ok_or_else(mismatch)
    }

    fn element_size(datatype: &Datatype) -> usize {
        encoding(datatype).map_or(0, |(encoding, _)| encoding.number.bytes())
    }

    fn decode_vec(raw: &[u8], datatype: &Datatype, count: usize) -> Option<Result<Vec<Self>>> {
        let (encoding, _) = encoding(datatype)?;
        let size = encoding.number.bytes();
        let raw = raw.get(..count.checked_mul(size)?)?;
        let values = raw.chunks_exact(size);
        Some(Ok(values
            .map(|bytes| Self(encoding.decode(bytes)))
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
