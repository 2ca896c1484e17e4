//! Latest values that other tasks publish for the watch. Nothing here waits for long: a slot holds one small value.

use tasks::Slot;

use crate::safety_state::SafetyState;

/// The drive's voltage as it is read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// Envelope, V peak.
    pub volts: f64,
    /// The input's sample that it belongs to.
    pub sample: u64,
    /// When it was read, host time, ns.
    pub at_ns: u64,
}

/// How hard the finger presses and pulls, as the force sensor tells: the most of what arrived together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    /// Normal force, N.
    pub normal_n: f64,
    /// Lateral force, N; either way.
    pub lateral_n: f64,
    /// The two without calibration, as the sensor itself says them, N.
    pub raw_n: [f64; 2],
    /// The normal axis was at the end of its range.
    pub saturated: bool,
    /// Host time, ns.
    pub at_ns: u64,
}

impl Press {
    /// The most of both, now.
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
    /// The drive read back; whoever reads the samples publishes it.
    pub readback: Slot<DriveReading>,
    /// When the force sensor's line was last looked at, host time, ns.
    pub force_polled_ns: Slot<u64>,
    /// The latest press; whoever reads the force sensor publishes it.
    pub press: Slot<Press>,
    /// State of the watch; the watch publishes it.
    pub state: Slot<SafetyState>,
}
