//! Measured amplitude at one place of the plate.

/// Amplitude at one place relative to the pickup's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Position along the plate, or distance from the finger's line across it, m.
    pub position_m: f64,
    /// Amplitude relative to the pickup's.
    pub ratio: f64,
    /// Standard error of the ratio, without the part common to all places.
    pub error: f64,
}
