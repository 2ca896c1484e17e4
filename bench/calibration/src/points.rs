//! Points of a calibration's curves.

use num_complex::Complex64;

/// One level of the ladder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PickupPoint {
    /// Drive level, V.
    pub drive_v: f64,
    /// Pickup's reading, peak, sample units.
    pub reading: f64,
    /// Known amplitude, m.
    pub known_m: f64,
    /// Its standard deviation, m.
    pub sigma_m: f64,
}

/// Velocity over force at one frequency, m/s/N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Admittance {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// As measured.
    pub measured: Complex64,
    /// As fitted.
    pub fitted: Complex64,
}
