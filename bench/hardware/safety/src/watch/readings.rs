//! Values that the watch shares with other tasks, without ever waiting for one of them. The watch may have a higher
//! priority: a task that is interrupted while it holds a slot could not continue before the watch sleeps.

use crate::dead_man::Hold;
use crate::dose::DoseLeft;
use crate::loop_delay::LoopDelay;
use crate::safety_lines::LineLevels;
use crate::safety_state::SafetyState;
use crate::signals::{DriveReading, Nonsense, Press, Signals};
use crate::stop_times::StopTimes;

/// Latest values of other tasks; a value that is being published at this moment keeps its previous state. Each has a
/// time by which the watch detects an old value, except for the amplitude, which the same task publishes as the
/// read-back.
#[derive(Default)]
pub(super) struct LatestReadings {
    pub(super) readback: Option<DriveReading>,
    pub(super) amplitude_m: Option<f64>,
    pub(super) force_polled_ns: Option<u64>,
    pub(super) press: Option<Press>,
    pub(super) nonsense: Option<Nonsense>,
    /// Judged by the state of the disk, not by its age.
    pub(super) kept_rise_k: Option<f64>,
}

impl LatestReadings {
    /// Updates the values from `signals`.
    pub(super) fn look(&mut self, signals: &Signals) {
        signals.readback.look(&mut self.readback);
        signals.amplitude_m.look(&mut self.amplitude_m);
        signals.force_polled_ns.look(&mut self.force_polled_ns);
        signals.press.look(&mut self.press);
        signals.nonsense.look(&mut self.nonsense);
        signals.kept_rise_k.look(&mut self.kept_rise_k);
    }
}

/// Values of the watch that wait to be published.
#[derive(Default)]
pub(super) struct Unpublished {
    pub(super) state: Option<SafetyState>,
    pub(super) stop_times: Option<Vec<StopTimes>>,
    pub(super) loop_delay: Option<LoopDelay>,
    pub(super) dose: Option<DoseLeft>,
    pub(super) hold: Option<Hold>,
    pub(super) rise_k: Option<f64>,
    pub(super) lines: Option<LineLevels>,
}

impl Unpublished {
    /// Publishes the values that have a free slot.
    pub(super) fn offer(&mut self, signals: &Signals) {
        signals.state.offer(&mut self.state);
        signals.stop_times.offer(&mut self.stop_times);
        signals.loop_delay.offer(&mut self.loop_delay);
        signals.dose.offer(&mut self.dose);
        signals.hold.offer(&mut self.hold);
        signals.rise_k.offer(&mut self.rise_k);
        signals.lines.offer(&mut self.lines);
    }
}
