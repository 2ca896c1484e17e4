//! Samples of a serial force sensor, and the trait of their decoders.

use crate::device_time::ExpectedCount;
use crate::force_source::LineFaults;

/// A sample of the force sensor at one time on the sensor's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSample {
    /// Device time, unwrapped to 64 bits, µs. It continues through a restart of the device.
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

/// A decoder that converts bytes to samples and resynchronises after errors.
pub trait Decoder: Send {
    /// Sets the device time expected when the next bytes arrive, µs. A sample that differs by more than a second comes from a
    /// restarted device; without an expected time, restarts are not detected.
    fn expect(&mut self, expected: Option<ExpectedCount>);
    /// Decodes `bytes`, cut anywhere, and appends the complete samples to `samples`.
    fn decode(&mut self, bytes: &[u8], samples: &mut Vec<ForceSample>);
    /// Returns the advance of the device's counter as sent, µs, which does not continue through a restart.
    fn advanced_us(&self) -> u64;
    /// Returns the faults since the start.
    fn faults(&self) -> LineFaults;
}
