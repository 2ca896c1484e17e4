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
