//! Protection of a person by the watch: from too much driving within an hour, and from a drive that continues after
//! release.

use super::{STALE_NS, Watch};
use crate::dead_man::{Hold, LetGo};
use crate::dose;
use crate::safety_lines::GpioError;
use crate::trip::Trip;

/// Temperature by which a plate may be warmer than its record states, K: as much as the record otherwise leads it.
const UNKEPT_K: f64 = 0.5;
const WARMTH_UNKEPT: &str = "the plate's temperature cannot be saved: the disk of the calibration has not answered \
                             since it rose by 1 K";

impl Watch {
    /// Counts the driving time; returns the trip once it is used up.
    pub(super) fn count_dose(&mut self, now_ns: u64) -> Option<Trip> {
        let commanded_v = self.drive.commanded().map_or(0.0, |drive| drive.envelope_v);
        let reading = self.readings.readback;
        let fresh = reading.filter(|reading| now_ns.saturating_sub(reading.at_ns) <= STALE_NS);
        let now_ns = now_ns as i64;
        self.dose.count(
            now_ns,
            commanded_v,
            fresh.map_or(0.0, |reading| reading.volts),
        );
        let remaining = self.dose.remaining(now_ns);
        self.unpublished.dose = Some(remaining);
        self.dose.spent_trip(&remaining)
    }

    /// Returns the trip of a bench with too little driving time left to be armed, or with driving time that is not
    /// kept.
    pub(super) fn dose_refuses(&self, now_ns: u64) -> Option<Trip> {
        let remaining = self.dose.remaining(now_ns as i64);
        let is_spent = remaining.wait_s > 0.0 || remaining.left_s <= 0.0;
        let trip = is_spent.then(|| dose::trip(&remaining));
        trip.or(self.dose.record_failure())
    }

    /// Returns the trip of a plate that is warmer than its record will state to the next program.
    pub(super) fn warmth_unkept(&self) -> Option<Trip> {
        let recorded_k = self.readings.kept_rise_k?;
        (self.rise_k > recorded_k + UNKEPT_K).then(|| Trip::Fault {
            message: WARMTH_UNKEPT.to_owned(),
        })
    }

    /// Polls the dead-man switch, if one is used; a switch that is not wired counts as released.
    pub(super) fn watch_hold(&mut self, now_ns: u64) -> Result<Option<Trip>, GpioError> {
        let Some(dead_man) = &mut self.dead_man else {
            return Ok(None);
        };
        let closed = match &mut self.lines.dead_man {
            Some(line) => line.is_high()?,
            None => false,
        };
        let is_driven = self
            .drive
            .commanded()
            .is_some_and(|drive| drive.envelope_v != 0.0);
        let release = dead_man.poll(closed, is_driven, now_ns);
        self.unpublished.hold = Some(dead_man.hold());
        Ok(release.map(|release| match release {
            LetGo::Released => Trip::DeadManReleased,
            LetGo::NotHeld(hold) => Trip::DeadManNotHeld { hold },
        }))
    }

    pub(super) fn hold_trip(&self) -> Option<Trip> {
        let hold = self.dead_man.as_ref()?.hold();
        (hold != Hold::Held).then_some(Trip::DeadManNotHeld { hold })
    }
}
