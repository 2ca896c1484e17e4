//! Trait of all force sources, with their state and faults.

use impedance::clock_alignment::ClockState;
use safety::Nonsense;
use serde::Serialize;

use crate::loss::SourceGone;

/// Time at which a force acted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// Time on the host's clock, s, for a sensor with its own clock, aligned with the host's.
    Host(f64),
    /// Frame of the sound card, counted from 0 as delivered, for a sensor on the card's inputs.
    Card(f64),
}

/// A force with its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedForce {
    /// Time at which the force acted.
    pub moment: Moment,
    /// Normal force, positive when the finger presses, N.
    pub normal_n: f64,
    /// Lateral force, positive towards increasing position, N.
    pub lateral_n: f64,
    /// Normal and lateral force as read by the sensor, without calibration, N.
    pub raw_n: [f64; 2],
    /// Whether the normal axis is at the end of its range.
    pub normal_saturated: bool,
    /// Whether the lateral axis is at the end of its range.
    pub lateral_saturated: bool,
}

impl TimedForce {
    /// Returns whether either axis is at the end of its range.
    #[must_use]
    pub fn saturated(&self) -> bool {
        self.normal_saturated || self.lateral_saturated
    }
}

/// Readings that a source has lost or rejected so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LineFaults {
    /// Readings dropped because they did not parse or failed their checksum.
    pub corrupt: u64,
    /// Readings that never arrived, from gaps in the sequence number.
    pub lost: u64,
    /// Readings dropped because their number or time was already seen.
    pub repeated: u64,
    /// Readings dropped because a later one had overtaken them.
    pub reordered: u64,
    /// Readings dropped because the sensor marked them as failed.
    pub failed: u64,
    /// Restarts of the sensor: its clock disagreed with the arrival of its readings by more than a second.
    pub restarted: u64,
}

impl LineFaults {
    /// Returns the faults since `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            corrupt: self.corrupt - earlier.corrupt,
            lost: self.lost - earlier.lost,
            repeated: self.repeated - earlier.repeated,
            reordered: self.reordered - earlier.reordered,
            failed: self.failed - earlier.failed,
            restarted: self.restarted - earlier.restarted,
        }
    }
}

/// State of a source.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SourceHealth {
    /// Readings lost or rejected so far.
    pub faults: LineFaults,
    /// Alignment of its clock with the host's; `None` for a source on the card's clock.
    pub clock: Option<ClockState>,
    /// Rate of its clock over the host's if it surely differs by more than the alignment can follow; `None` otherwise.
    pub pace: Option<f64>,
}

/// A source of forces. A silent source passes no forces; its user measures the silence.
pub trait ForceSource: Send {
    /// Reads without waiting the data that have arrived, and passes each force to `take`, in the order in which the forces
    /// acted; `now_s` returns the host's time, s.
    ///
    /// # Errors
    /// [`SourceGone`] if the source no longer exists.
    fn poll(
        &mut self,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone>;

    /// Returns the state of the source.
    fn health(&self) -> SourceHealth;

    /// Returns the number of readings a second that the device says it sends, if it says so.
    fn stated_hz(&self) -> Option<f64> {
        None
    }

    /// Returns the amount of invalid data up to the last poll, which was at `now_ns`.
    fn nonsense(&mut self, now_ns: u64) -> Nonsense;

    /// Returns the error for a source with a clock that runs `fast_ppm` fast against the sound card's, beyond the tolerance;
    /// the card's clock runs `card_ppm` fast against the computer's.
    fn off_rate(&self, fast_ppm: f64, card_ppm: f64) -> SourceGone {
        SourceGone::Clock {
            source_name: "force sensor",
            fast_ppm,
            card_ppm,
        }
    }
}
