//! Samples of the force sensor, faults of its line, and the trait of its decoders.

use serde::Serialize;

/// A sample of the force sensor at one instant of its own clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSample {
    /// Device time, unwrapped to 64 bit, µs.
    pub device_us: u64,
    /// Normal force, positive when the finger presses, N.
    pub normal_n: f64,
    /// Lateral force, positive towards increasing position, N.
    pub lateral_n: f64,
    /// Whether the normal axis is at the end of its range.
    pub normal_saturated: bool,
    /// Whether the lateral axis is at the end of its range.
    pub lateral_saturated: bool,
}

impl ForceSample {
    /// Returns whether either axis is at the end of its range.
    #[must_use]
    pub fn saturated(&self) -> bool {
        self.normal_saturated || self.lateral_saturated
    }
}

/// Faults of the line so far.
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
    /// Returns the faults since `before`.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            corrupt: self.corrupt - before.corrupt,
            lost: self.lost - before.lost,
            repeated: self.repeated - before.repeated,
        }
    }
}

/// A decoder that turns bytes into samples and resynchronises by itself.
pub trait Decoder: Send {
    /// Decodes `bytes`, cut anywhere, and appends the complete samples to `samples`.
    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>);
    /// Returns the faults since the start.
    fn faults(&self) -> LineFaults;
}
