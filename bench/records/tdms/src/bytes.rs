//! Bytes of a lead-in, of metadata or of a sample, in a segment's byte order.

/// Reads from a slice; each read is `None` past its end.
#[derive(Debug, Clone)]
pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
    length: usize,
    is_big_endian: bool,
}

impl<'a> Bytes<'a> {
    pub fn new(bytes: &'a [u8], is_big_endian: bool) -> Self {
        Self {
            rest: bytes,
            length: bytes.len(),
            is_big_endian,
        }
    }

    pub fn is_big_endian(&self) -> bool {
        self.is_big_endian
    }

    /// Returns the number of bytes read.
    pub fn position(&self) -> u64 {
        (self.length - self.rest.len()) as u64
    }

    /// Returns the number of bytes that remain.
    pub fn remaining(&self) -> u64 {
        self.rest.len() as u64
    }

    pub fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let count = usize::try_from(count).ok()?;
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    /// Reads bytes in the order of the file.
    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*taken)
    }

    /// Reads the bytes of a number, least significant first.
    pub fn ordered<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = self.array::<N>()?;
        if self.is_big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.ordered().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.ordered().map(u64::from_le_bytes)
    }

    /// Reads text with its length; bytes that are not UTF-8 are replaced.
    pub fn text(&mut self) -> Option<String> {
        let length = self.u32()?;
        let bytes = self.take(u64::from(length))?;
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    /// Reads a time, s since 1904: 2^-64 seconds and seconds, in the order of the bytes.
    pub fn timestamp(&mut self) -> Option<f64> {
        let all = u128::from_le_bytes(self.ordered()?);
        let seconds = (all >> 64) as u64 as i64;
        let fraction = all as u64 as f64 * 2f64.powi(-64);
        Some(seconds as f64 + fraction)
    }
}
