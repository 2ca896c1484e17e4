//! Sample formats of the converters.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// Sample format of a stream.
///
/// ```
/// use signalgen::StreamFormat;
///
/// assert_eq!("i24".parse(), Ok(StreamFormat::I24));
/// assert!("s24_3le".parse::<StreamFormat>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StreamFormat {
    /// 32-bit float.
    F32,
    /// 32-bit integer.
    I32,
    /// 24-bit integer in a container of 32 bits, least significant bits used; see [`I24`].
    I24,
    /// 16-bit integer.
    I16,
}

impl StreamFormat {
    /// Every sample format.
    pub const ALL: [Self; 4] = [Self::F32, Self::I32, Self::I24, Self::I16];
}

impl fmt::Display for StreamFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::I32 => "i32",
            Self::I24 => "i24",
            Self::I16 => "i16",
        })
    }
}

/// A name that is not a sample format.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("sample format {name:?} is not one of f32, i32, i24, i16")]
pub struct UnknownFormat {
    /// The name given.
    pub name: String,
}

impl FromStr for StreamFormat {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|format| format.to_string() == name)
            .ok_or_else(|| UnknownFormat {
                name: name.to_owned(),
            })
    }
}

/// A 24-bit sample in the low bits of a 32-bit container.
///
/// Writing sign-extends into the top byte. Reading ignores the top byte, which some drivers leave at 0 for negative
/// samples.
///
/// ```
/// use signalgen::{ConverterSample, I24};
///
/// assert_eq!(I24::from_unit(-0.5).container(), -(1 << 22));
/// assert_eq!(I24::from_container(0x00C0_0000).to_unit(), -0.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct I24(i32);

impl I24 {
    /// Largest sample, 2²³ − 1.
    pub const MAX: Self = Self((1 << 23) - 1);
    /// Smallest sample, −2²³.
    pub const MIN: Self = Self(-(1 << 23));

    /// Reads a sample from the low 24 bits of its container.
    #[must_use]
    pub fn from_container(container: i32) -> Self {
        Self((container << 8) >> 8)
    }

    /// Returns the sample in its container, sign-extended.
    #[must_use]
    pub fn container(self) -> i32 {
        self.0
    }
}

/// A converter's sample, convertible to and from units of full scale.
pub trait ConverterSample: Copy + Send + 'static {
    /// Silence.
    const ZERO: Self;

    /// Converts from units of full scale; integers saturate beyond ±1.
    fn from_unit(value: f32) -> Self;

    /// Converts to units of full scale.
    fn to_unit(self) -> f32;
}

impl ConverterSample for f32 {
    const ZERO: Self = 0.0;

    fn from_unit(value: f32) -> Self {
        value
    }

    fn to_unit(self) -> f32 {
        self
    }
}

// With a full scale of 2³¹, 2²³ or 2¹⁵, reading is exact up to rounding to f32; +1.0 saturates.
impl ConverterSample for i32 {
    const ZERO: Self = 0;

    fn from_unit(value: f32) -> Self {
        (value * 2_147_483_648.0) as Self
    }

    fn to_unit(self) -> f32 {
        self as f32 / 2_147_483_648.0
    }
}

impl ConverterSample for I24 {
    const ZERO: Self = Self(0);

    fn from_unit(value: f32) -> Self {
        let nearest = (value * 8_388_608.0).round() as i32;
        Self(nearest.clamp(Self::MIN.0, Self::MAX.0))
    }

    fn to_unit(self) -> f32 {
        self.0 as f32 / 8_388_608.0
    }
}

impl ConverterSample for i16 {
    const ZERO: Self = 0;

    fn from_unit(value: f32) -> Self {
        (value * 32_768.0).round() as Self
    }

    fn to_unit(self) -> f32 {
        f32::from(self) / 32_768.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn format_names_parse_back_and_others_are_refused() {
        for format in StreamFormat::ALL {
            assert_eq!(format.to_string().parse(), Ok(format));
        }
        let name = "u8".to_owned();
        assert_eq!(name.parse::<StreamFormat>(), Err(UnknownFormat { name }));
    }

    #[test]
    fn integers_survive_the_way_through_full_scale() {
        for raw in i16::MIN..=i16::MAX {
            assert_eq!(i16::from_unit(raw.to_unit()), raw);
        }
        for raw in I24::MIN.container()..=I24::MAX.container() {
            let sample = I24::from_container(raw);
            assert_eq!(sample.container(), raw);
            assert_eq!(I24::from_unit(sample.to_unit()), sample);
        }
        // f32 has 24 bits of precision, as many as the best converters.
        for raw in (i32::MIN..=i32::MAX - 255).step_by(256 * 4_099) {
            assert_eq!(i32::from_unit(raw.to_unit()), raw);
        }
    }

    #[test]
    fn samples_round_to_the_nearest_of_24_bits() {
        let step = 2.0_f32.powi(-23);
        for (value, expected) in [
            (0.49, 0),
            (0.51, 1),
            (-0.49, 0),
            (-0.51, -1),
            (1_000.4, 1_000),
            (-1_000.6, -1_001),
        ] {
            let sample = I24::from_unit(value * step);
            assert_eq!(sample.container(), expected, "{value}");
        }
    }

    #[test]
    fn full_scale_of_24_bits_is_two_to_the_23rd() {
        assert_eq!(I24::MIN.to_unit(), -1.0);
        assert_eq!(I24::MAX.to_unit(), 1.0 - 2.0_f32.powi(-23));
        assert_eq!(I24::from_unit(1.0), I24::MAX);
        assert_eq!(I24::from_unit(-1.0), I24::MIN);
        assert_eq!(I24::from_unit(0.25).container(), 1 << 21);
    }

    #[test]
    fn the_top_byte_of_a_24_bit_container_is_ignored() {
        for top in [0x00_u32, 0x5A, 0xFF] {
            let container = |low: u32| (top << 24 | low) as i32;
            assert_eq!(I24::from_container(container(0x00FF_FFFF)).container(), -1);
            assert_eq!(I24::from_container(container(0x0080_0000)), I24::MIN);
            assert_eq!(I24::from_container(container(0x007F_FFFF)), I24::MAX);
        }
    }

    #[test]
    fn beyond_full_scale_saturates_and_nan_is_silence() {
        assert_eq!(i16::from_unit(1.5), i16::MAX);
        assert_eq!(i16::from_unit(-1.5), i16::MIN);
        assert_eq!(i32::from_unit(1.0), i32::MAX);
        assert_eq!(i32::from_unit(-1.5), i32::MIN);
        for (value, limit) in [(1.5, I24::MAX), (f32::INFINITY, I24::MAX), (-1.5, I24::MIN)] {
            assert_eq!(I24::from_unit(value), limit);
        }
        assert_eq!(i16::from_unit(f32::NAN), 0);
        assert_eq!(I24::from_unit(f32::NAN), I24::ZERO);
        assert_eq!(i32::from_unit(f32::NAN), 0);
    }
}
