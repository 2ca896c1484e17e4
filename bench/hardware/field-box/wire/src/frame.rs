//! One frame on the line: mark and version, kind, fields, CRC-16; COBS-encoded, ended by a zero byte.

use core::ops::Deref;

use crc::{CRC_16_IBM_3740, Crc};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
/// Version of the protocol.
pub const VERSION: u8 = 1;
/// Upper half of a frame's first byte, which frames of a force sensor never have (`docs/force-protocol.md`); the lower half is
/// the version.
const MARK: u8 = 0xB0;
const FIRST: u8 = MARK | VERSION;
/// Length of the longest frame on the line, its zero byte included.
pub const LONGEST_BYTES: usize = 32;
/// COBS adds one byte to a frame this short; the delimiter is another.
const LONGEST_BODY: usize = LONGEST_BYTES - 2;
const CRC_BYTES: usize = 2;
/// Mark with version, and kind.
const HEAD_BYTES: usize = 2;

/// Reason for rejecting a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// Damaged: wrong length, encoding or checksum.
    Torn,
    /// Intact, but of the given other version of the protocol.
    Version(u8),
    /// Intact, but of another protocol or an unknown kind, or with fields that do not fit its kind.
    Unknown,
}

/// Encoded frame.
#[derive(Debug, Clone, Copy)]
pub struct Encoded {
    bytes: [u8; LONGEST_BYTES],
    length: usize,
}

impl Deref for Encoded {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// Fields of a frame while it is written, in order, little-endian.
pub(crate) struct Fields {
    body: [u8; LONGEST_BODY],
    length: usize,
}

impl Fields {
    pub(crate) fn new(kind: u8) -> Self {
        let mut body = [0; LONGEST_BODY];
        body[..HEAD_BYTES].copy_from_slice(&[FIRST, kind]);
        Self {
            body,
            length: HEAD_BYTES,
        }
    }

    /// Appends a field; all messages of this crate fit, as their tests show.
    pub(crate) fn with_bytes(mut self, bytes: &[u8]) -> Self {
        self.body[self.length..self.length + bytes.len()].copy_from_slice(bytes);
        self.length += bytes.len();
        self
    }

    pub(crate) fn encode(self) -> Encoded {
        let crc = CRC.checksum(&self.body[..self.length]).to_le_bytes();
        let frame = self.with_bytes(&crc);
        let mut bytes = [0; LONGEST_BYTES];
        let length = cobs::encode(&frame.body[..frame.length], &mut bytes);
        // The zero that follows is the delimiter.
        Encoded {
            bytes,
            length: length + 1,
        }
    }
}

/// Decodes a frame in place, without its delimiter; returns its kind and its fields.
pub(crate) fn decode(encoded: &mut [u8]) -> Result<(u8, &[u8]), Refused> {
    let length = cobs::decode_in_place(encoded).map_err(|_| Refused::Torn)?;
    let frame = encoded.get(..length).ok_or(Refused::Torn)?;
    let end = frame.len().checked_sub(CRC_BYTES).ok_or(Refused::Torn)?;
    let (body, crc) = frame.split_at(end);
    if CRC.checksum(body).to_le_bytes() != crc {
        return Err(Refused::Torn);
    }
    match body {
        [FIRST, kind, fields @ ..] => Ok((*kind, fields)),
        [first, ..] if first & 0xF0 == MARK => Err(Refused::Version(first & 0x0F)),
        _ => Err(Refused::Unknown),
    }
}
