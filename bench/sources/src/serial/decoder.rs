//! Samples of a serial force sensor, and the trait of its decoders.

use crate::device_time::ExpectedCount;
use crate::force_source::LineFaults;

/// A sample of the force sensor at one instant of its own clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSample {
    /// Device time, unwrapped to 64 bit, µs. It goes on through a restart of the device.
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

/// A decoder that turns bytes into samples and resynchronises by itself.
pub trait Decoder: Send {
    /// Takes what the device's clock should show when the next bytes arrive, µs. A sample that disagrees by more than a
    /// second is of a device that has restarted; without it that is not seen.
    fn expect(&mut self, expected: Option<ExpectedCount>);
    /// Decodes `bytes`, cut anywhere, and appends the complete samples to `samples`.
    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>);
    /// Returns the faults since the start.
    fn faults(&self) -> LineFaults;
}
