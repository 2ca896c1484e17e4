//! Numbers as bytes.

use num_complex::Complex64;

use crate::array::Element;

/// Type of a number in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl NumberType {
    /// Returns the bytes of a number.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Returns the kind of an array's elements.
    pub(crate) fn element(self, is_complex: bool) -> Element {
        let bits = (8 * self.bytes()) as u8;
        if is_complex {
            return Element::Complex { bits };
        }
        match self {
            Self::F16 | Self::F32 | Self::F64 => Element::Float { bits },
            Self::I8 | Self::I16 | Self::I32 | Self::I64 => Element::Integer {
                bits,
                is_signed: true,
            },
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => Element::Integer {
                bits,
                is_signed: false,
            },
        }
    }
}

/// Type and byte order of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Encoding {
    /// Type.
    pub(crate) number: NumberType,
    /// Whether the highest byte is the first.
    pub(crate) is_big_endian: bool,
}

impl Encoding {
    /// Returns the number at the start of `bytes`; NaN where they are too few.
    pub(crate) fn decode(self, bytes: &[u8]) -> f64 {
        macro_rules! decoded {
            ($type:ty) => {{
                match bytes.first_chunk() {
                    Some(bytes) if self.is_big_endian => <$type>::from_be_bytes(*bytes) as f64,
                    Some(bytes) => <$type>::from_le_bytes(*bytes) as f64,
                    None => f64::NAN,
                }
            }};
        }
        match self.number {
            NumberType::I8 => decoded!(i8),
            NumberType::U8 => decoded!(u8),
            NumberType::I16 => decoded!(i16),
            NumberType::U16 => decoded!(u16),
            NumberType::I32 => decoded!(i32),
            NumberType::U32 => decoded!(u32),
            NumberType::I64 => decoded!(i64),
            NumberType::U64 => decoded!(u64),
            NumberType::F16 => {
                let bits = match bytes.first_chunk() {
                    Some(bytes) if self.is_big_endian => u16::from_be_bytes(*bytes),
                    Some(bytes) => u16::from_le_bytes(*bytes),
                    None => return f64::NAN,
                };
                half(bits)
            }
            NumberType::F32 => decoded!(f32),
            NumberType::F64 => decoded!(f64),
        }
    }

    /// Returns the complex number at the start of `bytes`: its real part, then its imaginary part.
    pub(crate) fn decode_complex(self, bytes: &[u8]) -> Complex64 {
        let imaginary = bytes.get(self.number.bytes()..).unwrap_or(&[]);
        Complex64::new(self.decode(bytes), self.decode(imaginary))
    }
}

/// Returns the value of a float of 16 bits.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let mantissa = f64::from(bits & 0x3ff);
    sign * match exponent {
        0 => mantissa * 2f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + mantissa) * 2f64.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_both_byte_orders() {
        let encoding = |number, is_big_endian| Encoding {
            number,
            is_big_endian,
        };
        let (little, big) = ((-2i16).to_le_bytes(), (-2i16).to_be_bytes());
        assert_eq!(encoding(NumberType::I16, false).decode(&little), -2.0);
        assert_eq!(encoding(NumberType::I16, true).decode(&big), -2.0);
        let value = encoding(NumberType::F64, true).decode(&0.1f64.to_be_bytes());
        assert_eq!(value, 0.1);
        let pair = [1.5f32.to_le_bytes(), (-2.5f32).to_le_bytes()].concat();
        let complex = encoding(NumberType::F32, false).decode_complex(&pair);
        assert_eq!(complex, Complex64::new(1.5, -2.5));
        assert!(encoding(NumberType::U32, false).decode(&[1, 2]).is_nan());
    }

    #[test]
    fn floats_of_sixteen_bits_have_their_values() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x3555, 0.333_251_953_125),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x7bff, 65504.0),
            (0x7c00, f64::INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }
}
