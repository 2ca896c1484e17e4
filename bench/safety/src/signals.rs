//! Latest values that other tasks publish for the watch; each slot holds one small value, so nobody waits for long.

use tasks::Slot;

use crate::safety_state::SafetyState;

/// Voltage of the drive as read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// Envelope, V peak.
    pub volts: f64,
    /// Sample of the input that the envelope belongs to.
    pub sample: u64,
    /// Host time of the reading, ns.
    pub at_ns: u64,
}

/// Greatest forces among the force readings that arrived together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    /// Normal force, N.
    pub normal_n: f64,
    /// Lateral force, N; of either sign.
    pub lateral_n: f64,
    /// Normal and lateral force by the sensor itself, without calibration, N.
    pub raw_n: [f64; 2],
    /// Whether the normal axis was at the end of its range.
    pub saturated: bool,
    /// Host time of the latest reading, ns.
    pub at_ns: u64,
}

impl Press {
    /// Returns the greater forces of both, at the later time.
    #[must_use]
    pub fn or_harder(self, other: Self) -> Self {
        let wider = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        Self {
            normal_n: self.normal_n.max(other.normal_n),
            lateral_n: wider(self.lateral_n, other.lateral_n),
            raw_n: [
                self.raw_n[0].max(other.raw_n[0]),
                wider(self.raw_n[1], other.raw_n[1]),
            ],
            saturated: self.saturated | other.saturated,
            at_ns: self.at_ns.max(other.at_ns),
        }
    }
}

/// Latest values that the watch judges, and the state that it publishes.
#[derive(Debug, Default)]
pub struct Signals {
    /// Read-back of the drive; published by the task that reads the samples.
    pub readback: Slot<DriveReading>,
    /// Host time at which the force sensor's port was last polled, ns.
    pub force_polled_ns: Slot<u64>,
    /// Latest forces; published by the task that reads the force sensor.
    pub press: Slot<Press>,
    /// State of the watch; published by the watch.
    pub state: Slot<SafetyState>,
}
