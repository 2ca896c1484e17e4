//! Limits that the watch enforces.

/// Least and greatest plausible sensitivity of either axis of a force sensor that reads newtons: a calibration is never
/// off by more than these factors.
pub const SENSITIVITY: [f64; 2] = [0.5, 2.0];

/// Limits that the watch enforces; from `[safety]` in `bench.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyLimits {
    /// Largest normal force, N.
    pub max_normal_n: f64,
    /// Largest lateral force in either direction, N.
    pub max_lateral_n: f64,
    /// Largest relative difference of the read-back from the commanded envelope.
    pub readback_tolerance: f64,
    /// Read-back below which the drive counts as silent, V peak.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, ns.
    pub loop_latency_ns: u64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Longest silence of the sound card or of the force sensor, ns.
    pub silence_ns: u64,
}
