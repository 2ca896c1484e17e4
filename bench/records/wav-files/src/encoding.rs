//! Encodings of samples.

use std::io::{self, Read};

/// Encoding of the samples of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// 8 bits, of which 128 is zero.
    U8,
    /// 16 bits.
    I16,
    /// 24 bits.
    I24,
    /// 32 bits.
    I32,
    /// 64 bits.
    I64,
    /// Floats of 32 bits.
    F32,
    /// Floats of 64 bits.
    F64,
    /// 24 bits in four bytes: in the upper three by the WAV specification, in the lower three by ALSA's S24_LE.
    I24In32,
    /// 24 bits in the lower three of four bytes.
    LowI24,
}

impl Encoding {
    /// Returns the encoding of samples with a format tag for integers or floats, their valid bits, and their bytes; `None` if
    /// it is not read.
    pub(crate) fn new(is_float: bool, bits: u16, bytes: u64) -> Option<Self> {
        match (is_float, bytes, bits) {
            (false, 1, 1..=8) => Some(Self::U8),
            (false, 2, 9..=16) => Some(Self::I16),
            (false, 3, 9..=24) => Some(Self::I24),
            (false, 4, 17..=24) => Some(Self::I24In32),
            (false, 4, 9..=32) => Some(Self::I32),
            (false, 8, 33..=64) => Some(Self::I64),
            (true, 4, 32) => Some(Self::F32),
            (true, 8, 64) => Some(Self::F64),
            _ => None,
        }
    }

    /// Returns whether recordings of a bench may have such samples.
    pub(crate) fn is_of_recordings(self) -> bool {
        !matches!(self, Self::U8 | Self::I64)
    }

    /// Returns whether the samples are integers.
    #[must_use]
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the bytes of a sample.
    #[must_use]
    pub fn bytes(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::I16 => 2,
            Self::I24 => 3,
            Self::I32 | Self::F32 | Self::I24In32 | Self::LowI24 => 4,
            Self::F64 | Self::I64 => 8,
        }
    }

    /// Appends the samples to `out`; full scale of integers becomes ±1.
    pub(crate) fn decode(self, bytes: &[u8], out: &mut Vec<f32>) {
        if self == Self::F32 {
            out.extend(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
        } else {
            self.visit(bytes, |sample| out.push(sample as f32));
        }
    }

    /// Calls `visitor` with every sample in `bytes`; full scale of integers becomes ±1.
    pub fn visit(self, bytes: &[u8], mut visitor: impl FnMut(f64)) {
        let i32_units = |bytes: [u8; 4]| f64::from(i32::from_le_bytes(bytes)) / 2_147_483_648.0;
        match self {
            Self::U8 => bytes
                .iter()
                .for_each(|byte| visitor((f64::from(*byte) - 128.0) / 128.0)),
            Self::I16 => {
                for b in bytes.as_chunks().0 {
                    visitor(f64::from(i16::from_le_bytes(*b)) / 32_768.0);
                }
            }
            Self::I24 => {
                for &[a, b, c] in bytes.as_chunks().0 {
                    visitor(i32_units([0, a, b, c]));
                }
            }
            Self::I32 | Self::I24In32 => {
                for b in bytes.as_chunks().0 {
                    visitor(i32_units(*b));
                }
            }
            Self::LowI24 => {
                for &[a, b, c, _] in bytes.as_chunks().0 {
                    visitor(i32_units([0, a, b, c]));
                }
            }
            Self::I64 => {
                for b in bytes.as_chunks().0 {
                    visitor(i64::from_le_bytes(*b) as f64 / 9_223_372_036_854_775_808.0);
                }
            }
            Self::F32 => {
                for b in bytes.as_chunks().0 {
                    visitor(f64::from(f32::from_le_bytes(*b)));
                }
            }
            Self::F64 => {
                for b in bytes.as_chunks().0 {
                    visitor(f64::from_le_bytes(*b));
                }
            }
        }
    }

    /// Returns the encoding with the place of 24 bits in four bytes determined from `samples`, the bytes of all of them.
    pub(crate) fn resolve(self, samples: impl Read) -> io::Result<Self> {
        if self != Self::I24In32 {
            return Ok(self);
        }
        let mut samples = samples;
        let mut bytes = vec![0; 1 << 16];
        loop {
            let n_read = fill(&mut samples, &mut bytes)?;
            if n_read == 0 {
                // Every sample fits both places: the specification decides.
                return Ok(Self::I32);
            }
            let words = bytes[..n_read].as_chunks::<4>().0;
            let extends = words
                .iter()
                .all(|&[_, _, c, top]| top == 0 || top == 0xff && c >= 0x80);
            let has_low_bytes = words.iter().any(|word| word[0] != 0);
            match (has_low_bytes, extends) {
                (true, true) => return Ok(Self::LowI24),
                (_, false) => return Ok(Self::I32),
                (false, true) => {}
            }
        }
    }
}

/// Reads until `bytes` is full or the source ends; returns the number of bytes read.
fn fill(source: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut n_read = 0;
    while n_read < bytes.len() {
        match source.read(&mut bytes[n_read..]) {
            Ok(0) => break,
            Ok(n) => n_read += n,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(n_read)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a 24-bit converter.
    const VALUES: [i32; 5] = [0, 1, -1, 8_388_607, -8_388_608];

    fn decoded(words: &[[u8; 4]]) -> Vec<f32> {
        let bytes = words.concat();
        let encoding = Encoding::I24In32.resolve(bytes.as_slice()).unwrap();
        let mut out = Vec::new();
        encoding.decode(&bytes, &mut out);
        out
    }

    #[test]
    fn twenty_four_bits_are_read_at_either_end_of_four_bytes() {
        let expected = VALUES.map(|value| value as f32 / 8_388_608.0);
        let high = VALUES.map(|value| (value << 8).to_le_bytes());
        let low = VALUES.map(i32::to_le_bytes);
        let low_without_sign = VALUES.map(|value| (value & 0x00ff_ffff).to_le_bytes());
        for words in [high, low, low_without_sign] {
            assert_eq!(decoded(&words), expected, "{words:?}");
        }
        // Silence before the samples decides nothing.
        let late = [&[[0; 4]; 20_000][..], &low].concat();
        assert_eq!(decoded(&late)[20_000..], expected);
        assert_eq!(decoded(&[[0; 4]]), [0.0]);
    }

    #[test]
    fn doubles_are_read_and_stay_nan() {
        let bytes: Vec<u8> = [0.25, f64::NAN, -1.0]
            .iter()
            .flat_map(|value: &f64| value.to_le_bytes())
            .collect();
        let mut out = Vec::new();
        Encoding::F64.decode(&bytes, &mut out);
        assert_eq!((out[0], out[2]), (0.25, -1.0));
        assert!(out[1].is_nan());
    }
}
