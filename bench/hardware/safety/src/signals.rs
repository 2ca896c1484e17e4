//! Latest values that other tasks publish for the watch; each slot holds one small value, so no task waits for long.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

use tasks::Slot;
use tasks::scheduling::Scheduling;

use crate::dead_man::Hold;
use crate::dose::DoseLeft;
use crate::loop_delay::LoopDelay;
use crate::losses::{Losses, RearmObstacle};
use crate::safety_lines::LineLevels;
use crate::safety_state::SafetyState;
use crate::stop_times::StopTimes;

/// Voltage of the drive as read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// Envelope, V peak.
    pub volts: f64,
    /// Sample of the input that the envelope belongs to.
    pub sample: u64,
    /// Frames rendered less those captured, lost ones included, when the latest block arrived.
    pub ahead: i64,
    /// Host time of the reading, ns.
    pub at_ns: u64,
}

/// Greatest forces among the force readings that arrived together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    /// Normal force, N; negative when the plate is pulled.
    pub normal_n: f64,
    /// Lateral force, N; of either sign.
    pub lateral_n: f64,
    /// Normal and lateral force as the sensor gives them, without calibration, N.
    pub raw_n: [f64; 2],
    /// Whether the normal axis was at the end of its range.
    pub saturated: bool,
    /// Host time of the latest reading, ns.
    pub at_ns: u64,
}

impl Press {
    /// Returns the force of greater size on each axis, at the later time.
    #[must_use]
    pub fn or_harder(self, other: Self) -> Self {
        let wider = |a: f64, b: f64| {
            if b.is_nan() || b.abs() > a.abs() {
                b
            } else {
                a
            }
        };
        Self {
            normal_n: wider(self.normal_n, other.normal_n),
            lateral_n: wider(self.lateral_n, other.lateral_n),
            raw_n: [
                wider(self.raw_n[0], other.raw_n[0]),
                wider(self.raw_n[1], other.raw_n[1]),
            ],
            saturated: self.saturated | other.saturated,
            at_ns: self.at_ns.max(other.at_ns),
        }
    }
}

/// Bytes of the force sensor's port that belong to no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Nonsense {
    /// Number of bytes since the last reading.
    pub bytes: u64,
    /// Whether they have arrived for so long that no reading can be expected.
    pub lasts: bool,
}

/// Latest values that the watch judges, and the state that it publishes.
#[derive(Debug, Default)]
pub struct Signals {
    /// Read-back of the drive; published by the task that reads the samples.
    pub readback: Slot<DriveReading>,
    /// Largest amplitude of the plate in the latest readings, m; published by a task that knows the pickup's scale.
    pub amplitude_m: Slot<f64>,
    /// Host time at which the force sensor's port was last polled, ns.
    pub force_polled_ns: Slot<u64>,
    /// Bytes that the force sensor's port sends instead of readings; published by the task that reads the force sensor.
    pub nonsense: Slot<Nonsense>,
    /// Latest forces; published by the task that reads the force sensor.
    pub press: Slot<Press>,
    /// Number of polls of the task that decides about the drive: its sign of life.
    pub decisions: AtomicU64,
    /// Number of polls for the operator's keys: the sign of life of the thread that reads the stop key. Zero if no
    /// thread reads keys.
    pub hearings: AtomicU64,
    /// Whether the bench is about to end at the operator's or the system's request: a kill then is no failure. Published by
    /// the threads that read keys and signals.
    pub ends: AtomicBool,
    /// Time for which the computer has been suspended since the bench was opened, ns, which the clock of the watch does
    /// not count. Published by the task that reads the sensors.
    pub suspended_ns: AtomicU64,
    /// Delay from a command to its read-back, as shown by the latest rise of the drive; published by the watch.
    pub loop_delay: Slot<LoopDelay>,
    /// Times of the hardware stops, once they have been exercised; published by the watch.
    pub stop_times: Slot<Vec<StopTimes>>,
    /// Longest time from one poll of the watch to the next, ns; published by the watch.
    pub longest_away_ns: AtomicU64,
    /// Scheduling of the watch's thread; published by the watch if it has its own thread.
    pub scheduling: Slot<Scheduling>,
    /// Remaining driving time of the hour; published by the watch.
    pub dose: Slot<DoseLeft>,
    /// Next action required at the dead-man switch, on a bench that uses one; published by the watch.
    pub hold: Slot<Hold>,
    /// Levels of the watch's lines; published by the watch, also for screens.
    pub lines: Arc<Slot<LineLevels>>,
    /// Lost devices; published by the watch and by the task that reads the sensors, also for screens.
    pub losses: Arc<Losses>,
    /// Estimated temperature of the plate above the room, K; published by the watch.
    pub rise_k: Slot<f64>,
    /// Least temperature above the room that the record of the plate's warmth states, K; published by the task that
    /// keeps the record, if there is one.
    pub kept_rise_k: Slot<f64>,
    /// State of the watch; published by the watch.
    pub state: Slot<SafetyState>,
}

impl Signals {
    /// Returns what keeps a trip latched although the operator re-arms; `None` if nothing does.
    #[must_use]
    pub fn rearm_obstacle(&self) -> Option<RearmObstacle> {
        let lost = self.losses.first().map(RearmObstacle::Lost);
        let lines = self.lines.get().unwrap_or_default();
        let obstacle = match (lines.has_failed, lines.estop_open) {
            (true, _) => Some(RearmObstacle::Lines),
            (false, Some(true)) => Some(RearmObstacle::EmergencyStop),
            (false, _) => None,
        };
        lost.or(obstacle)
    }
}
