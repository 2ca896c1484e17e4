//! Encoding of a field box's messages (`docs/field-box-protocol.md`), written from the description and tested with the same
//! examples as the bench's.

use crc::{CRC_16_IBM_3740, Crc};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
/// First byte of each frame: version 1 of this protocol.
const VERSION: u8 = 0xB1;
/// Kinds of messages.
const IDENTITY: u8 = 0x01;
const REPORT: u8 = 0x02;
const ASK: u8 = 0x10;
const WORD: u8 = 0x11;
/// Longest frame allowed on the line, bytes.
const LONGEST: usize = 32;

/// Request of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Request {
    Identity,
    Lines {
        number: u16,
        enable: bool,
        heartbeat: bool,
    },
}

/// Fields of a report, in sending order.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reading {
    pub(super) number: u16,
    pub(super) device_us: u32,
    pub(super) counts: [i32; 2],
    pub(super) position: i32,
    /// Bits: e-stop closed, button, dead man, enable, heartbeat, normal and lateral saturated, converter silent.
    pub(super) levels: u8,
    pub(super) stop: u8,
    pub(super) last_word: u16,
}

/// Appends a report's frame to `out`.
pub(super) fn put_report(reading: &Reading, out: &mut Vec<u8>) {
    let mut raw = Vec::with_capacity(LONGEST);
    raw.extend([VERSION, REPORT]);
    raw.extend(reading.number.to_le_bytes());
    raw.extend(reading.device_us.to_le_bytes());
    for count in reading.counts {
        raw.extend(count.to_le_bytes());
    }
    raw.extend(reading.position.to_le_bytes());
    raw.extend([reading.levels, reading.stop]);
    raw.extend(reading.last_word.to_le_bytes());
    put(raw, out);
}

/// Appends the frame with the box's identity.
pub(super) fn put_identity(firmware: [u8; 3], serial: [u8; 8], report_hz: u16, out: &mut Vec<u8>) {
    let mut raw = vec![VERSION, IDENTITY];
    raw.extend(firmware);
    raw.extend(serial);
    raw.extend(report_hz.to_le_bytes());
    raw.push(24);
    put(raw, out);
}

fn put(mut raw: Vec<u8>, out: &mut Vec<u8>) {
    raw.extend(CRC.checksum(&raw).to_le_bytes());
    // COBS by its definition: each run up to a zero, preceded by its length plus one.
    for run in raw.split(|byte| *byte == 0) {
        out.push(run.len() as u8 + 1);
        out.extend(run);
    }
    out.push(0);
}

/// Bytes received from the bench since the last frame.
#[derive(Debug, Default)]
pub(super) struct Ear(Vec<u8>);

impl Ear {
    /// Takes a byte; returns the request of the frame that it completes. An invalid frame is dropped.
    pub(super) fn hear(&mut self, byte: u8) -> Option<Request> {
        if byte != 0 {
            if self.0.len() <= LONGEST {
                self.0.push(byte);
            }
            return None;
        }
        let frame = std::mem::take(&mut self.0);
        let raw = unstuff(&frame).filter(|_| frame.len() <= LONGEST)?;
        let (body, crc) = raw.split_at_checked(raw.len().checked_sub(2)?)?;
        if CRC.checksum(body).to_le_bytes() != crc {
            return None;
        }
        match *body {
            [VERSION, ASK] => Some(Request::Identity),
            [VERSION, WORD, low, high, levels @ 0..=3] => Some(Request::Lines {
                number: u16::from_le_bytes([low, high]),
                enable: levels & 1 != 0,
                heartbeat: levels & 2 != 0,
            }),
            _ => None,
        }
    }
}

fn unstuff(frame: &[u8]) -> Option<Vec<u8>> {
    let (mut raw, mut index) = (Vec::new(), 0);
    while index < frame.len() {
        let length = usize::from(frame[index]);
        raw.extend_from_slice(frame.get(index + 1..index + length)?);
        index += length;
        if index < frame.len() {
            raw.push(0);
        }
    }
    Some(raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn golden(name: &str) -> Vec<u8> {
        let lines = include_str!("../../../bench/hardware/field-box/wire/golden.txt").lines();
        let mut entries = lines.filter_map(|line| line.split_once(": "));
        let (_, hex) = entries.find(|(key, _)| *key == name).unwrap();
        let bytes = hex.split(' ');
        bytes
            .map(|byte| u8::from_str_radix(byte, 16).unwrap())
            .collect()
    }

    #[test]
    fn reports_encode_to_their_golden_bytes() {
        let mut out = Vec::new();
        let serial = [0xE6, 0x61, 0x41, 0x04, 0x03, 0x00, 0x2A, 0x21];
        put_identity([1, 2, 3], serial, 4000, &mut out);
        assert_eq!(out, golden("identity"));
        out.clear();
        let reading = Reading {
            number: 0xFFFE,
            device_us: 0x0102_0304,
            counts: [272_629, -33_974],
            position: -1200,
            levels: 1 | 8 | 32,
            stop: 0,
            last_word: 258,
        };
        put_report(&reading, &mut out);
        assert_eq!(out, golden("report"));
        out.clear();
        let stop_report = Reading {
            number: 0,
            device_us: u32::MAX,
            counts: [i32::MIN, i32::MAX],
            position: i32::MIN,
            levels: 2 | 4 | 16 | 64 | 128,
            stop: 1,
            last_word: 0xFFFF,
        };
        put_report(&stop_report, &mut out);
        assert_eq!(out, golden("report, stopped"));
    }

    #[test]
    fn only_golden_requests_are_decoded() {
        let requests = |bytes: &[u8]| -> Vec<Request> {
            let mut ear = Ear::default();
            bytes.iter().filter_map(|&byte| ear.hear(byte)).collect()
        };
        let lines = |number, enable, heartbeat| Request::Lines {
            number,
            enable,
            heartbeat,
        };
        assert_eq!(requests(&golden("ask")), [Request::Identity]);
        assert_eq!(requests(&golden("word, off")), [lines(0, false, false)]);
        let on_word = golden("word, on");
        assert_eq!(requests(&on_word), [lines(0xABCD, true, true)]);
        for bit in 0..8 * (on_word.len() - 1) {
            let mut bad_word = on_word.clone();
            bad_word[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(requests(&bad_word), [], "bit {bit}");
        }
        assert_eq!(requests(&[7; 100_000]), []);
        assert_eq!(requests(&golden("report")), []);
    }
}
