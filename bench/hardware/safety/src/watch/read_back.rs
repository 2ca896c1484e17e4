//! Judgement of the drive by its read-back.

use super::{OFF_AFTER_NS, STALE_NS, Watch};
use crate::guard::Commanded;
use crate::loop_delay::DELAY_WITHIN_S;
use crate::readback::ReadbackMisfit;
use crate::safety_state::SafetyState;
use crate::signals::DriveReading;
use crate::trip::Trip;

impl Watch {
    pub(super) fn readback_wrong(&mut self, commanded: Commanded, now_ns: u64) -> Option<Trip> {
        self.readback.command(commanded.frame, commanded.envelope_v);
        self.delay.command(commanded.frame, commanded.envelope_v);
        let reading = self.readings.readback?;
        let age_ns = now_ns.saturating_sub(reading.at_ns);
        if age_ns > self.limits.loop_latency_ns.max(STALE_NS) {
            return Some(Trip::ReadbackMissing);
        }
        if self.exercise.is_some() {
            return None;
        }
        if let Some(trip) = self.delay_wrong(reading) {
            return Some(trip);
        }
        let misfit = self
            .readback
            .reading(reading.sample, reading.ahead, reading.volts)?;
        let ReadbackMisfit {
            measured_v,
            commanded_v,
        } = misfit;
        if self.state == SafetyState::Armed && commanded_v.1 <= 0.0 {
            return Some(Trip::AliveUndriven { measured_v });
        }
        if self.state == SafetyState::Armed {
            return Some(Trip::Readback {
                measured_v,
                commanded_v,
            });
        }
        // A disarmed amplifier must be silent under any command.
        (measured_v > self.limits.readback_floor_v)
            .then_some(Trip::AliveWhileDisarmed { measured_v })
    }

    /// Returns the alarm of a drive that is alive although it was stopped. It replaces the reason of the stop, because
    /// a message about a pressed e-stop must not suggest that the plate is off.
    pub(super) fn alive_after_stop(&self, now_ns: u64) -> Option<Trip> {
        let SafetyState::Tripped { trip } = &self.state else {
            return None;
        };
        let deadline_ns = self.tripped_at_ns + OFF_AFTER_NS + self.limits.loop_latency_ns;
        let reading = self.readings.readback?;
        let known = matches!(trip, Trip::AliveWhileDisarmed { .. });
        let alive = reading.volts > self.limits.readback_floor_v;
        (!known && now_ns > deadline_ns && reading.at_ns > deadline_ns && alive).then_some(
            Trip::AliveWhileDisarmed {
                measured_v: reading.volts,
            },
        )
    }

    /// Publishes the loop's delay once a rise of the drive has shown it; trips if it is not the measured one.
    fn delay_wrong(&mut self, reading: DriveReading) -> Option<Trip> {
        let DriveReading {
            sample,
            ahead,
            volts,
            ..
        } = reading;
        let delay = self.delay.reading(sample, ahead, volts);
        self.readback.set_rising(self.delay.is_rising());
        let delay = delay?;
        self.unpublished.loop_delay = Some(delay);
        let (measured_s, present_s) = (self.limits.measured_delay_s?, delay.seconds);
        let is_off = (present_s - measured_s).abs() > DELAY_WITHIN_S;
        (is_off && self.state == SafetyState::Armed).then_some(Trip::LoopDelay {
            measured_s,
            present_s,
        })
    }
}
