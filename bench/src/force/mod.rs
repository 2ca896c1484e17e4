//! The force sensor's serial line: two formats (`docs/force-protocol.md`), one stream of samples on the audio clock.

mod correction;
mod frames;
mod lines;
mod link;

pub use correction::{Correction, Implausible, MOST_CROSSTALK, SENSITIVITY};
pub use frames::FrameDecoder;
pub use lines::LineDecoder;
pub use link::{ForceLink, ForcePort, TimedForce, open_port};

use serde::{Deserialize, Serialize};

/// What the sensor said at one instant of its own clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSample {
    /// Device time, unwrapped to 64 bit, µs.
    pub device_us: u64,
    /// Normal force, positive when the finger presses, N.
    pub normal_n: f64,
    /// Lateral force, positive towards increasing position, N.
    pub lateral_n: f64,
    /// The normal axis is at the end of its range.
    pub normal_saturated: bool,
    /// The lateral axis is at the end of its range.
    pub lateral_saturated: bool,
}

impl ForceSample {
    /// Either axis is at the end of its range.
    #[must_use]
    pub fn saturated(&self) -> bool {
        self.normal_saturated || self.lateral_saturated
    }
}

/// What went wrong on the line so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LineFaults {
    /// Frames or lines dropped because they did not parse or failed their checksum.
    pub corrupt: u64,
    /// Frames that never arrived, by the sequence number.
    pub lost: u64,
    /// Frames dropped because their number or time had been seen.
    pub repeated: u64,
}

impl LineFaults {
    /// What came since `before`.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            corrupt: self.corrupt - before.corrupt,
            lost: self.lost - before.lost,
            repeated: self.repeated - before.repeated,
        }
    }
}

/// Which of the two formats the sensor speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceProtocol {
    /// Binary, COBS and CRC-16, with a sequence number.
    Frames,
    /// Text, one line a sample.
    Lines,
}

/// Turns bytes into samples; resynchronises by itself.
pub trait Decoder: Send {
    /// Reads `bytes`, whatever their cut, and appends the complete samples to `samples`.
    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>);
    /// Faults since the start.
    fn faults(&self) -> LineFaults;
}

impl ForceProtocol {
    /// A decoder in its initial state.
    pub fn decoder(self) -> Box<dyn Decoder> {
        match self {
            Self::Frames => Box::new(FrameDecoder::default()),
            Self::Lines => Box::new(LineDecoder::default()),
        }
    }
}

/// A 32-bit microsecond counter carried on past its wraps.
#[derive(Debug, Default)]
struct Unwrap {
    last: Option<u64>,
}

impl Unwrap {
    fn peek(&self, wrapped_us: u32) -> i64 {
        let last = self.last.unwrap_or(u64::from(wrapped_us));
        // As a signed difference a step back in time stays small instead of looking like a wrap.
        i64::from(wrapped_us.wrapping_sub(last as u32) as i32)
    }

    fn advance(&mut self, wrapped_us: u32) -> u64 {
        let last = self.last.unwrap_or(u64::from(wrapped_us));
        let now = last.saturating_add_signed(self.peek(wrapped_us));
        self.last = Some(now);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::Unwrap;

    #[test]
    fn device_time_goes_on_past_the_wrap() {
        let mut clock = Unwrap::default();
        assert_eq!(clock.advance(u32::MAX - 49), u64::from(u32::MAX) - 49);
        assert_eq!(clock.advance(50), u64::from(u32::MAX) + 51);
        assert_eq!(clock.peek(40), -10);
        assert_eq!(clock.advance(150), u64::from(u32::MAX) + 151);
    }
}
