//! The bench's part of an exercise: each observation moves the exercise to its next stage.

use safety::{SafetyState, Trip};

use super::{Exercise, Order, Sight, Stage, UNSEEN_S};
use crate::signs::is_sign;

/// Longest wait for the drive to sound, s.
const START_S: f64 = 10.0;
/// Longest wait for the operator at each step, s.
pub(super) const PATIENCE_S: f64 = 60.0;
/// Time from a trip until the amplifier is off, even with a card that renders no samples, s (HAZARDS.md, "What stops the
/// drive").
const DISABLED_S: f64 = 0.02;
/// Row of a lost card in FAULTS.md.
const CARD: u8 = 5;
/// Time for which the drive must sound again before it counts as resumed, s.
const RESUMED_S: f64 = 0.3;
/// Time limit for re-arming to succeed, s.
const REARMED_S: f64 = 0.5;

const STOPPED_BY_KEY: &str = "the operator's key stopped the drive first";

/// Observation of the bench within a stage.
#[derive(Debug, Clone, Copy)]
struct Moment<'a> {
    sight: Sight<'a>,
    now_s: f64,
    trip: Option<&'a Trip>,
    /// Time since the stage began, s.
    waited_s: f64,
}

impl Exercise {
    /// Takes an observation of the bench; returns the order to the bench.
    pub fn poll(&mut self, sight: Sight<'_>) -> Option<Order> {
        let now_s = sight.now_s;
        let is_first = self.since_s.is_none();
        let moment = Moment {
            sight,
            now_s,
            trip: match sight.safety {
                SafetyState::Tripped { trip } => Some(trip),
                _ => None,
            },
            waited_s: now_s - *self.since_s.get_or_insert(now_s),
        };
        self.note_silence(moment);
        if let Some(trip) = moment.trip
            && self.is_noticed()
            && !self.must_stop()
        {
            self.reject_needless_stop(trip);
            return None;
        }
        match self.stage {
            Stage::Settling { .. } if is_first => return Some(Order::Drive),
            Stage::Settling { sounding_s, paused } => {
                return self.settle(moment, sounding_s, paused);
            }
            Stage::Asked => self.await_act(moment),
            Stage::Begun => self.await_sign(moment),
            Stage::Noticed => self.limit_wait(moment, PATIENCE_S, "nobody acknowledged it"),
            Stage::Acknowledged { rearming_s } => self.await_remedy(moment, rearming_s),
            Stage::Rearmed => self.limit_wait(moment, PATIENCE_S, "nobody resumed"),
            Stage::Resuming { sounding_s } => self.await_drive(moment, sounding_s),
            Stage::Over(_) => {}
        }
        None
    }

    /// Begins the fault once the bench has driven without interruption for long enough.
    fn settle(
        &mut self,
        moment: Moment<'_>,
        sounding_s: Option<f64>,
        paused: bool,
    ) -> Option<Order> {
        if let Some(trip) = moment.trip.filter(|trip| **trip != Trip::Operator) {
            self.miss(format!("the bench stopped before the fault: {trip}"));
            return None;
        }
        let is_operators_turn = moment.trip.is_some() || paused;
        let is_driving = moment.sight.sounds && !is_operators_turn;
        let sounding_s = is_driving.then(|| sounding_s.unwrap_or(moment.now_s));
        self.stage = Stage::Settling { sounding_s, paused };
        match sounding_s {
            None => {
                let limit_s = if is_operators_turn {
                    PATIENCE_S
                } else {
                    START_S
                };
                self.limit_wait(moment, limit_s, "the drive did not begin");
                None
            }
            Some(sounding_s) if moment.now_s - sounding_s < self.settle_s => None,
            Some(_) => self.begin(moment.now_s),
        }
    }

    /// Begins the fault, or asks the operator to cause it.
    fn begin(&mut self, now_s: f64) -> Option<Order> {
        self.note = None;
        self.begun_s = now_s;
        if self.is_manual {
            self.enter(Stage::Asked, now_s);
            None
        } else {
            self.enter(Stage::Begun, now_s);
            Some(Order::Begin)
        }
    }

    /// Waits until the bench stops because of the operator's act.
    fn await_act(&mut self, moment: Moment<'_>) {
        match moment.trip {
            Some(Trip::Operator) => self.miss(STOPPED_BY_KEY),
            Some(trip) if is_sign(self.fault, trip) => {
                // The moment of the action is unknown: time counts from its detection by the bench.
                self.begun_s = moment.now_s;
                self.notice(moment, trip.to_string());
            }
            Some(trip) => self.reject_other_stop(trip),
            None => {
                let reason = "nothing was done, or the bench did not see it";
                self.limit_wait(moment, PATIENCE_S, reason);
            }
        }
    }

    /// Waits until the bench stops or flags the fault.
    fn await_sign(&mut self, moment: Moment<'_>) {
        let must_stop = self.must_stop();
        match (moment.trip, moment.sight.flag) {
            (Some(Trip::Operator), _) => self.miss(STOPPED_BY_KEY),
            (Some(trip), _) if !must_stop => self.reject_needless_stop(trip),
            (Some(trip), _) if is_sign(self.fault, trip) => self.notice(moment, trip.to_string()),
            (Some(trip), _) => self.reject_other_stop(trip),
            (None, Some(flag)) if !must_stop => self.notice(moment, flag.to_owned()),
            (None, _) => {
                let reason = if must_stop {
                    "the bench did not stop"
                } else {
                    "the bench flagged nothing"
                };
                self.limit_wait(moment, UNSEEN_S.max(self.within_s), reason);
            }
        }
    }

    /// Waits until the latch is released, if the operator has tried to re-arm, or the remedy is complete.
    fn await_remedy(&mut self, moment: Moment<'_>, rearming_s: Option<f64>) {
        if let Some(asked_s) = rearming_s {
            if *moment.sight.safety == SafetyState::Disarmed {
                self.times.rearmed_s = self.since_fault_s(moment.now_s);
                self.note = None;
                self.enter(Stage::Rearmed, moment.now_s);
                return;
            }
            if moment.now_s - asked_s > REARMED_S {
                self.stage = Stage::Acknowledged { rearming_s: None };
                self.note = Some("The cause is still there.");
            }
        }
        self.limit_wait(moment, PATIENCE_S, "the right action was not taken in time");
    }

    /// Waits until the drive has resumed.
    fn await_drive(&mut self, moment: Moment<'_>, sounding_s: Option<f64>) {
        if moment.trip.is_some() {
            self.note = Some("Stopped again: the cause is still there.");
            self.enter(Stage::Acknowledged { rearming_s: None }, moment.now_s);
        } else if moment.sight.sounds {
            let sounding_s = sounding_s.unwrap_or(moment.now_s);
            self.stage = Stage::Resuming {
                sounding_s: Some(sounding_s),
            };
            if moment.now_s - sounding_s >= RESUMED_S {
                self.complete(moment.now_s);
            }
        } else {
            self.stage = Stage::Resuming { sounding_s: None };
            self.limit_wait(moment, START_S, "the drive did not resume");
        }
    }

    /// Records how and when the bench showed the fault.
    fn notice(&mut self, moment: Moment<'_>, sign: String) {
        self.sign = sign;
        self.times.shown_s = self.since_fault_s(moment.now_s);
        self.noticed_s = moment.now_s;
        self.enter(Stage::Noticed, moment.now_s);
        self.note_silence(moment);
    }

    /// Records when the drive fell silent after the bench stopped it.
    fn note_silence(&mut self, moment: Moment<'_>) {
        if moment.trip.is_none() || !self.is_noticed() || self.times.silent_s.is_some() {
            return;
        }
        // A card that renders no samples cannot report silence; its amplifier is off by then.
        let is_card_stopped = self.fault.row().row == Some(CARD);
        let is_disabled = is_card_stopped && moment.now_s - self.noticed_s >= DISABLED_S;
        if !moment.sight.sounds || is_disabled {
            self.times.silent_s = self.since_fault_s(moment.now_s);
        }
    }

    /// Ends the exercise as missed for `reason` if the stage has lasted longer than `limit_s`.
    fn limit_wait(&mut self, moment: Moment<'_>, limit_s: f64, reason: &str) {
        if moment.waited_s > limit_s {
            self.miss(reason);
        }
    }

    fn reject_other_stop(&mut self, trip: &Trip) {
        self.miss(format!("the bench stopped for another reason: {trip}"));
    }

    fn reject_needless_stop(&mut self, trip: &Trip) {
        self.miss(format!(
            "the bench stopped, and should have gone on: {trip}"
        ));
    }
}
