//! Points of a calibration's curves.

use num_complex::Complex64;

/// A point of the pickup's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PickupPoint {
    /// Drive level, V peak.
    pub drive_v: f64,
    /// Peak reading of the pickup, sample units.
    pub reading: f64,
    /// Known peak amplitude, m.
    pub known_m: f64,
    /// Standard deviation of the known amplitude, m.
    pub sigma_m: f64,
    /// Phase of the known displacement minus that of the reading, rad; `None` if only its amplitude is known.
    pub turn_rad: Option<f64>,
}

/// Velocity over force at one frequency, m/s/N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Admittance {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Measured admittance, m/s/N.
    pub measured: Complex64,
    /// Fitted admittance, m/s/N.
    pub fitted: Complex64,
}

/// Returns `value` with its sign and this many decimals; a value that is rounded to zero has no sign.
///
/// ```
/// use calibration_rig::points::signed;
///
/// assert_eq!(signed(-0.0021, 3), "-0.002");
/// assert_eq!(signed(-0.0003, 3), "0.000");
/// ```
#[must_use]
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c));
    if is_zero {
        text.trim_start_matches(['+', '-']).to_owned()
    } else {
        text
    }
}
