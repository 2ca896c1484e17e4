//! The binary format: COBS frames with a CRC-16, a sequence number and device time.

use crc::{CRC_16_IBM_3740, Crc};

use super::decoder::{Decoder, ForceSample};
use crate::device_time::{DeviceCount, ExpectedCount, Place};
use crate::force_source::LineFaults;
use crate::numbering::Numbering;
use crate::pace::RawCount;

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
const VERSION: u8 = 1;
const FRAME_BYTES: usize = 18;
const NORMAL_SATURATED: u8 = 1;
const LATERAL_SATURATED: u8 = 2;
/// Longest encoded frame: COBS adds one byte to a frame this short.
const ENCODED_BYTES: usize = FRAME_BYTES + 1;

/// Decoder of the binary format.
///
/// ```
/// use sources::serial::{Decoder, FrameDecoder};
///
/// let mut decoder = FrameDecoder::default();
/// let mut samples = Vec::new();
/// decoder.decode(&[1, 2, 3, 0], &mut samples); // torn: no frame
/// assert!(samples.is_empty());
/// assert_eq!(decoder.faults().corrupt, 1);
/// ```
#[derive(Default)]
pub struct FrameDecoder {
    encoded: Vec<u8>,
    overlong: bool,
    numbering: Numbering,
    clock: DeviceCount,
    raw: RawCount,
    expected: Option<ExpectedCount>,
    faults: LineFaults,
}

struct Frame {
    sequence: u16,
    device_us: u32,
    normal_un: i32,
    lateral_un: i32,
    status: u8,
}

impl Frame {
    /// Decodes a frame in place; `None` when the length, the version or the checksum is wrong.
    fn parse(encoded: &mut [u8]) -> Option<Self> {
        let length = cobs::decode_in_place(encoded).ok()?;
        let frame: &[u8; FRAME_BYTES] = encoded.get(..length)?.try_into().ok()?;
        let (body, crc) = frame.split_at(FRAME_BYTES - 2);
        let field = |offset: usize| {
            [
                body[offset],
                body[offset + 1],
                body[offset + 2],
                body[offset + 3],
            ]
        };
        (body[0] == VERSION && CRC.checksum(body).to_le_bytes() == crc).then(|| Self {
            sequence: u16::from_le_bytes([body[1], body[2]]),
            device_us: u32::from_le_bytes(field(3)),
            normal_un: i32::from_le_bytes(field(7)),
            lateral_un: i32::from_le_bytes(field(11)),
            status: body[15],
        })
    }
}

impl FrameDecoder {
    fn end_of_frame(&mut self) -> Option<ForceSample> {
        let frame = if self.overlong {
            None
        } else {
            Frame::parse(&mut self.encoded)
        };
        self.encoded.clear();
        self.overlong = false;
        let Some(frame) = frame else {
            self.numbering.corrupt(&mut self.faults);
            return None;
        };
        self.raw.take(frame.device_us);
        let place = self.clock.place(frame.device_us, self.expected.as_ref());
        if matches!(place, Place::Restarted(_)) {
            self.faults.restarted += 1;
            self.numbering.restart();
        }
        let later = place != Place::Past;
        if !self
            .numbering
            .follows(frame.sequence, later, &mut self.faults)
        {
            return None;
        }
        let device_us = self.clock.take(frame.device_us, place)?;
        Some(ForceSample {
            device_us,
            normal_n: f64::from(frame.normal_un) * 1e-6,
            lateral_n: f64::from(frame.lateral_un) * 1e-6,
            normal_saturated: frame.status & NORMAL_SATURATED != 0,
            lateral_saturated: frame.status & LATERAL_SATURATED != 0,
        })
    }
}

impl Decoder for FrameDecoder {
    fn expect(&mut self, expected: Option<ExpectedCount>) {
        self.expected = expected;
    }

    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>) {
        for &byte in bytes {
            if byte == 0 {
                if !self.encoded.is_empty() || self.overlong {
                    samples.extend(self.end_of_frame());
                }
            } else if self.encoded.len() < ENCODED_BYTES {
                self.encoded.push(byte);
            } else {
                self.overlong = true;
            }
        }
    }

    fn advanced_us(&self) -> u64 {
        self.raw.advanced()
    }

    fn faults(&self) -> LineFaults {
        self.faults
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(in crate::serial) fn encode(
        sequence: u16,
        device_us: u32,
        normal_un: i32,
        lateral_un: i32,
    ) -> Vec<u8> {
        let mut body = vec![VERSION];
        body.extend(sequence.to_le_bytes());
        body.extend(device_us.to_le_bytes());
        body.extend(normal_un.to_le_bytes());
        body.extend(lateral_un.to_le_bytes());
        body.push(0);
        body.extend(CRC.checksum(&body).to_le_bytes());
        let mut encoded = vec![0; body.len() + 1];
        let length = cobs::encode(&body, &mut encoded);
        encoded.truncate(length);
        encoded.push(0);
        encoded
    }

    fn decode(decoder: &mut FrameDecoder, bytes: &[u8]) -> Vec<ForceSample> {
        let mut samples = Vec::new();
        decoder.decode(bytes, &mut samples);
        samples
    }

    #[test]
    fn the_checksum_is_the_documented_one() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29B1);
    }

    /// Fault 22.
    /// Hazard 20.
    #[test]
    fn lost_corrupt_and_repeated_frames_are_each_counted_once() {
        let mut decoder = FrameDecoder::default();
        let mut bytes = Vec::new();
        for sequence in [65533u16, 65534, 65535, 0, 0, 5] {
            let device_us = u32::from(sequence.wrapping_add(1000));
            bytes.extend(encode(sequence, device_us, 1, 2));
        }
        let mut corrupt = encode(6, 1006, 1, 2);
        corrupt[4] ^= 0x40;
        bytes.extend(corrupt);
        bytes.extend(encode(7, 1007, 650_000, -81_000));
        // New number, but not a later time.
        bytes.extend(encode(8, 1007, 1, 2));
        let samples = decode(&mut decoder, &bytes);
        assert_eq!(samples.len(), 6);
        assert_eq!(
            decoder.faults(),
            LineFaults {
                corrupt: 1,
                lost: 4,
                repeated: 2,
                ..LineFaults::default()
            }
        );
        assert_eq!((samples[5].normal_n, samples[5].lateral_n), (0.65, -0.081));
    }

    proptest! {
        /// Fault 22.
        #[test]
        fn any_cut_of_the_stream_gives_the_same_samples(cut in 1usize..64, noise in prop::collection::vec(any::<u8>(), 0..40)) {
            let mut bytes = noise;
            bytes.push(0);
            for sequence in 0..50u16 {
                bytes.extend(encode(sequence, u32::from(sequence) * 100, i32::from(sequence) * 1000, -7));
            }
            let samples = decode(&mut FrameDecoder::default(), &bytes);
            let mut decoder = FrameDecoder::default();
            let pieces: Vec<_> = bytes.chunks(cut).flat_map(|piece| decode(&mut decoder, piece)).collect();
            prop_assert_eq!(&samples, &pieces);
            prop_assert!(samples.len() >= 50);
        }

        /// Fault 21.
        #[test]
        fn noise_is_never_a_sample(noise in prop::collection::vec(any::<u8>(), 0..4000)) {
            // One frame in 2^24 of random bytes would pass version and checksum.
            prop_assert!(decode(&mut FrameDecoder::default(), &noise).is_empty());
        }
    }
}
