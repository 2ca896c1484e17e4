//! A plate's response at one frequency.

use num_complex::Complex64;

/// The response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Ratio of the pickup's to the drive's envelope, in sample units.
    pub ratio: Complex64,
}
