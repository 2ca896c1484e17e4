//! One sample of the force sensor, and what a decoder of its line must do.

use serde::Serialize;

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

/// Turns bytes into samples; resynchronises by itself.
pub trait Decoder: Send {
    /// Reads `bytes`, whatever their cut, and appends the complete samples to `samples`.
    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>);
    /// Faults since the start.
    fn faults(&self) -> LineFaults;
}
