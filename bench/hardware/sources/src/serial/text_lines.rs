//! The text format: one line `<device µs>,<normal mN>,<lateral mN>` for each sample.

use super::decoder::{Decoder, ForceSample};
use crate::device_time::{DeviceCount, ExpectedCount, Place};
use crate::force_source::LineFaults;
use crate::pace::RawCount;

/// Largest advance of device time between two lines that confirm a restart, µs.
const LONGEST_STEP_US: u32 = 1_000_000;
/// Largest length of a line in this format, bytes.
const LONGEST_LINE_BYTES: usize = 80;

/// Decoder of the text format.
///
/// ```
/// use sources::serial::{Decoder, LineDecoder};
///
/// let mut decoder = LineDecoder::default();
/// let mut samples = Vec::new();
/// decoder.decode(b"5,-80\n1000,652.5,-81\n2000,65", &mut samples);
/// assert_eq!((samples.len(), samples[0].normal_n), (1, 0.6525));
/// ```
#[derive(Default)]
pub struct LineDecoder {
    line: Vec<u8>,
    /// Whether the first line, usually incomplete, has ended.
    is_synchronised: bool,
    clock: DeviceCount,
    raw: RawCount,
    expected: Option<ExpectedCount>,
    /// Device time of the last line if it does not match the expected time (restarted device or garbled line), µs.
    suspect: Option<u32>,
    faults: LineFaults,
}

fn parse(line: &[u8]) -> Option<(u32, f64, f64)> {
    let mut fields = std::str::from_utf8(line)
        .ok()?
        .trim_end_matches('\r')
        .split(',')
        .map(str::trim);
    let device_us = fields.next()?.parse().ok()?;
    let mut force = || {
        fields
            .next()?
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    };
    let (normal_mn, lateral_mn) = (force()?, force()?);
    fields
        .next()
        .is_none()
        .then_some((device_us, normal_mn, lateral_mn))
}

impl LineDecoder {
    /// Returns whether the line before this one also came from a restarted device. A single line may be garbled, since lines
    /// have no checksum, so the next one decides.
    fn is_confirmed(&mut self, device_us: u32) -> bool {
        let Some(before_us) = self.suspect.replace(device_us) else {
            return false;
        };
        let step_us = device_us.wrapping_sub(before_us);
        let confirmed = (1..=LONGEST_STEP_US).contains(&step_us);
        if confirmed {
            self.suspect = None;
        } else {
            self.faults.corrupt += 1;
        }
        confirmed
    }

    fn end_of_line(&mut self) -> Option<ForceSample> {
        if !std::mem::replace(&mut self.is_synchronised, true) || self.line.first() == Some(&b'#') {
            return None;
        }
        let is_complete = self.line.len() <= LONGEST_LINE_BYTES;
        let Some((device_us, normal_mn, lateral_mn)) = parse(&self.line).filter(|_| is_complete)
        else {
            self.faults.corrupt += 1;
            return None;
        };
        self.raw.take(device_us);
        let place = self.clock.place(device_us, self.expected.as_ref());
        if matches!(place, Place::Restarted(_)) {
            if !self.is_confirmed(device_us) {
                return None;
            }
            self.faults.restarted += 1;
        } else if self.suspect.take().is_some() {
            self.faults.corrupt += 1;
        }
        let Some(device_us) = self.clock.take(device_us, place) else {
            self.faults.repeated += 1;
            return None;
        };
        Some(ForceSample {
            device_us,
            normal_n: normal_mn * 1e-3,
            lateral_n: lateral_mn * 1e-3,
            normal_saturated: false,
            lateral_saturated: false,
        })
    }
}

impl Decoder for LineDecoder {
    fn expect(&mut self, expected: Option<ExpectedCount>) {
        self.expected = expected;
    }

    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>) {
        for &byte in bytes {
            if byte == b'\n' {
                samples.extend(self.end_of_line());
                self.line.clear();
            } else if self.line.len() <= LONGEST_LINE_BYTES {
                self.line.push(byte);
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
mod tests {
    use super::*;

    /// Fault 21.
    #[test]
    fn lines_are_read_comments_skipped_and_nonsense_counted() {
        let mut decoder = LineDecoder::default();
        let mut samples = Vec::new();
        let text = b"3.1,-80\n# bench meter\n1000,652.5,-81\r\n2000,nan,0\n2000,650\n2000,650,0,1\n900,1,1\n2000, 650.0, 12.5\n";
        for piece in text.chunks(7) {
            decoder.decode(piece, &mut samples);
        }
        assert_eq!(samples.len(), 2);
        assert_eq!(
            samples[0],
            ForceSample {
                device_us: 1000,
                normal_n: 0.6525,
                lateral_n: -0.081,
                normal_saturated: false,
                lateral_saturated: false,
            }
        );
        assert_eq!(samples[1].lateral_n, 0.0125);
        assert_eq!(
            decoder.faults(),
            LineFaults {
                corrupt: 3,
                lost: 0,
                repeated: 1,
                ..LineFaults::default()
            }
        );
    }

    #[test]
    fn the_beginning_of_a_line_that_is_too_long_is_no_sample() {
        let mut decoder = LineDecoder::default();
        let mut samples = Vec::new();
        let digits = "1".repeat(LONGEST_LINE_BYTES);
        decoder.decode(format!("\n1000,650.0,{digits}\n").as_bytes(), &mut samples);
        assert_eq!((samples.len(), decoder.faults().corrupt), (0, 1));
        let fits = LONGEST_LINE_BYTES - "2000,650.0,".len();
        decoder.decode(
            format!("2000,650.0,{}\n", "0".repeat(fits)).as_bytes(),
            &mut samples,
        );
        assert_eq!((samples.len(), decoder.faults().corrupt), (1, 1));
    }

    /// Fault 44.
    #[test]
    fn an_endless_line_takes_no_memory() {
        let mut decoder = LineDecoder::default();
        decoder.decode(&[b'1'; 100_000], &mut Vec::new());
        assert!(decoder.line.capacity() <= 2 * LONGEST_LINE_BYTES);
    }
}
