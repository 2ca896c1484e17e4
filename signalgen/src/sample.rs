//! Sample formats of the converters.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// Sample format of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleFormat {
    /// 32-bit float.
    F32,
    /// 32-bit integer.
    I32,
    /// 16-bit integer.
    I16,
}

impl fmt::Display for SampleFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::I32 => "i32",
            Self::I16 => "i16",
        })
    }
}

/// A name of no sample format.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("sample format {name:?} is not one of f32, i32, i16")]
pub struct UnknownFormat {
    /// The name given.
    pub name: String,
}

impl FromStr for SampleFormat {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "f32" => Ok(Self::F32),
            "i32" => Ok(Self::I32),
            "i16" => Ok(Self::I16),
            _ => Err(UnknownFormat {
                name: name.to_owned(),
            }),
        }
    }
}

/// A converter's sample, to and from units of full scale.
pub trait ConverterSample: Copy + Send + 'static {
    /// Silence.
    const ZERO: Self;

    /// From units of full scale; beyond ±1 it saturates.
    fn from_unit(value: f32) -> Self;

    /// To units of full scale.
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

// A full scale of 2³¹ and 2¹⁵ makes reading exact but for rounding to f32; `as` saturates +1.0.
impl ConverterSample for i32 {
    const ZERO: Self = 0;

    fn from_unit(value: f32) -> Self {
        (value * 2_147_483_648.0) as Self
    }

    fn to_unit(self) -> f32 {
        self as f32 / 2_147_483_648.0
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
    fn names_go_in_and_out() {
        for format in [SampleFormat::F32, SampleFormat::I32, SampleFormat::I16] {
            assert_eq!(format.to_string().parse(), Ok(format));
        }
        let error = "i24".parse::<SampleFormat>().unwrap_err();
        assert!(error.to_string().contains("\"i24\""), "{error}");
    }

    #[test]
    fn integers_survive_the_way_through_full_scale() {
        for raw in i16::MIN..=i16::MAX {
            assert_eq!(i16::from_unit(raw.to_unit()), raw);
        }
        // f32 holds 24 bits, which is what the best converters have.
        for raw in (i32::MIN..=i32::MAX - 255).step_by(256 * 4_099) {
            assert_eq!(i32::from_unit(raw.to_unit()), raw);
        }
    }

    #[test]
    fn beyond_full_scale_saturates_and_nan_is_silence() {
        assert_eq!(i16::from_unit(1.5), i16::MAX);
        assert_eq!(i16::from_unit(-1.5), i16::MIN);
        assert_eq!(i32::from_unit(1.0), i32::MAX);
        assert_eq!(i32::from_unit(-1.5), i32::MIN);
        assert_eq!(i16::from_unit(f32::NAN), 0);
        assert_eq!(i32::from_unit(f32::NAN), 0);
    }
}
