//! What the watch allows.

/// Least and greatest sensitivity of either axis of a force sensor that reads newtons: its calibration is never off by more
/// than these factors.
pub const SENSITIVITY: [f64; 2] = [0.5, 2.0];

/// Limits that the watch enforces; from `[safety]` in `bench.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyLimits {
    /// Largest normal force a finger may be met with, N.
    pub max_normal_n: f64,
    /// Largest lateral force either way, N.
    pub max_lateral_n: f64,
    /// Relative difference of the read-back from the commanded envelope.
    pub readback_tolerance: f64,
    /// Read-back below this is silence, V.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, ns.
    pub loop_latency_ns: u64,
    /// Rate of the samples, Hz.
    pub rate_hz: f64,
    /// Longest silence of the sound card or of the force sensor, ns.
    pub silence_ns: u64,
}
