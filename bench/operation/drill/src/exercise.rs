//! One exercise: a fault, the response of bench and operator, and its times. Free of side effects: the next order depends only
//! on the observations and the operator's actions.

use faults::{FaultKind, Remedy, Required};
use safety::{SafetyState, Trip};
use tui::Action;
use tui::drill_view::DrillStep;

use crate::signs::is_sign;
use crate::times::{ExerciseOutcome, Times};

/// Longest wait for the drive to sound, s.
const START_S: f64 = 10.0;
/// Time limit for the bench to stop or flag a fault, s.
const UNSEEN_S: f64 = 2.0;
/// Longest wait for the operator at each step, s.
pub(crate) const PATIENCE_S: f64 = 60.0;
/// Time from a trip until the amplifier is off, even with a card that renders no samples, s (HAZARDS.md, "What stops the
/// drive").
const DISABLED_S: f64 = 0.02;
/// Row of a lost card in FAULTS.md.
const CARD: u8 = 5;
/// Time for which the drive must sound again before it counts as resumed, s.
const RESUMED_S: f64 = 0.3;
/// Time limit for re-arming to succeed, s.
const REARMED_S: f64 = 0.5;

/// Observation of the bench at one moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<'a> {
    /// Time on a monotonic clock, s.
    pub now_s: f64,
    /// State of the safety watch.
    pub safety: &'a SafetyState,
    /// Whether the plate is driven, ramps included.
    pub sounds: bool,
    /// Flag raised by the bench since the fault began.
    pub flag: Option<&'a str>,
}

/// An order of the exercise to the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Drive.
    Drive,
    /// Stop in an orderly way.
    Pause,
    /// Stop at once, at the operator's request.
    Stop,
    /// Inject the fault.
    Begin,
    /// Remove the cause of the fault.
    End,
    /// Release the latch.
    Rearm,
}

/// Stage of an exercise; times in s on the caller's clock.
#[derive(Debug, Clone, PartialEq)]
enum Stage {
    /// Driving before the fault, since `sounding_s`, unless the operator has `paused` or stopped it.
    Settling {
        sounding_s: Option<f64>,
        paused: bool,
    },
    /// The operator has been asked to cause the fault.
    Asked,
    /// The fault is present; the bench has not shown it.
    Begun,
    /// The bench has shown the fault and waits for the operator's acknowledgement.
    Noticed,
    /// The operator has acknowledged the fault and applies the remedy; holds the time of the latest attempt to re-arm.
    Acknowledged {
        rearming_s: Option<f64>,
    },
    /// Re-armed but not driven.
    Rearmed,
    /// Driven again, since `sounding_s`.
    Resuming {
        sounding_s: Option<f64>,
    },
    Over(ExerciseOutcome),
}

/// One exercise.
#[derive(Debug, Clone)]
pub(crate) struct Exercise {
    fault: FaultKind,
    is_manual: bool,
    /// Longest time allowed until the drive is silent, s.
    within_s: f64,
    settle_s: f64,
    stage: Stage,
    since_s: Option<f64>,
    begun_s: f64,
    noticed_s: f64,
    sign: String,
    note: Option<&'static str>,
    times: Times,
}

impl Exercise {
    /// Begins an exercise with the fault after `settle_s` of driving; `is_manual` if a person causes it. `silence_s` is the
    /// bench's setting.
    pub fn new(fault: FaultKind, is_manual: bool, settle_s: f64, silence_s: f64) -> Self {
        let within_s = match fault.row().required {
            Required::Stop(within) => within.seconds(silence_s),
            _ => UNSEEN_S,
        };
        Self {
            fault,
            is_manual,
            within_s,
            settle_s,
            stage: Stage::Settling {
                sounding_s: None,
                paused: false,
            },
            since_s: None,
            begun_s: 0.0,
            noticed_s: 0.0,
            sign: String::new(),
            note: None,
            times: Times::default(),
        }
    }

    /// Returns the fault.
    pub fn fault(&self) -> FaultKind {
        self.fault
    }

    /// Returns the outcome; `None` while the exercise lasts.
    pub fn outcome(&self) -> Option<&ExerciseOutcome> {
        match &self.stage {
            Stage::Over(outcome) => Some(outcome),
            _ => None,
        }
    }

    /// Returns the times so far.
    pub fn times(&self) -> Times {
        self.times
    }

    /// Returns the longest time allowed until the drive is silent or the flag is raised, s.
    pub fn within_s(&self) -> f64 {
        self.within_s
    }

    /// Returns how the bench showed the fault: the reason of the stop, or the flag.
    pub fn sign(&self) -> &str {
        &self.sign
    }

    /// Returns the remark on the operator's last key.
    pub fn note(&self) -> Option<&'static str> {
        self.note
    }

    /// Whether the operator is shown a paused bench.
    pub fn is_paused(&self) -> bool {
        matches!(
            self.stage,
            Stage::Rearmed | Stage::Settling { paused: true, .. }
        )
    }

    /// Returns the step requested of the operator.
    pub fn current_step(&self) -> DrillStep {
        match (&self.stage, self.fault.row().remedy) {
            (Stage::Asked, _) => DrillStep::Act,
            (Stage::Noticed, _) => DrillStep::Acknowledge,
            (Stage::Acknowledged { .. }, Remedy::Rearm(_)) => DrillStep::Rearm,
            (Stage::Acknowledged { .. }, Remedy::Repeat) => DrillStep::Repeat,
            (Stage::Acknowledged { .. }, Remedy::Restart(_)) => DrillStep::Quit,
            (Stage::Rearmed, _) => DrillStep::Resume,
            _ => DrillStep::Watch,
        }
    }

    /// Returns the instruction to the operator.
    pub fn instruction(&self) -> String {
        let row = self.fault.row();
        match (&self.stage, row.remedy) {
            (Stage::Settling { .. } | Stage::Begun, _) if self.is_manual => {
                "The faint tone sounds. Nothing is to be done yet.".to_owned()
            }
            (Stage::Settling { .. } | Stage::Begun, _) => {
                "Watch the bench: a fault will come.".to_owned()
            }
            (Stage::Asked, _) => row.real.map_or("", |real| real.words).to_owned(),
            (Stage::Noticed, _) if row.required == Required::Flag => {
                format!("Flagged: {}. Space when you have seen it.", self.sign)
            }
            (Stage::Noticed, _) => {
                format!("Stopped: {}. Space when you have seen it.", self.sign)
            }
            (Stage::Acknowledged { .. }, Remedy::Rearm(removed)) if self.is_manual => {
                format!("{removed} Then re-arm: x, y.")
            }
            (Stage::Acknowledged { .. }, Remedy::Rearm(_)) => {
                format!("Re-arm: x, y. The cause is removed; it was: {}.", row.words)
            }
            (Stage::Acknowledged { .. }, Remedy::Repeat) => {
                format!("Repeat the trial: r, y. It was: {}.", row.words)
            }
            (Stage::Acknowledged { .. }, Remedy::Restart(mended)) => format!(
                "End the program: q, y; nothing can be re-armed. It was: {}. {mended} A session is resumed with \
                 --resume.",
                row.words
            ),
            (Stage::Rearmed, _) => "Resume: p.".to_owned(),
            (Stage::Resuming { .. }, _) => "The drive resumes.".to_owned(),
            (Stage::Over(ExerciseOutcome::Met), _) => "Met.".to_owned(),
            (Stage::Over(ExerciseOutcome::Missed(reason)), _) => format!("Missed: {reason}."),
        }
    }

    /// Takes an observation of the bench; returns the order to the bench.
    pub fn poll(&mut self, sight: Sight<'_>) -> Option<Order> {
        let now_s = sight.now_s;
        let first = self.since_s.is_none();
        let waited_s = now_s - *self.since_s.get_or_insert(now_s);
        let trip = match sight.safety {
            SafetyState::Tripped { trip } => Some(trip),
            _ => None,
        };
        self.note_silence(trip, sight);
        let goes_on = self.fault.row().required == Required::Flag;
        let is_noticed = matches!(self.stage, Stage::Noticed | Stage::Acknowledged { .. });
        if let Some(trip) = trip.filter(|_| goes_on && is_noticed) {
            self.end(should_have_gone_on(trip));
            return None;
        }
        match &mut self.stage {
            Stage::Settling { sounding_s, paused } => {
                if first {
                    return Some(Order::Drive);
                }
                if let Some(trip) = trip.filter(|trip| **trip != Trip::Operator) {
                    let reason = format!("the bench stopped before the fault: {trip}");
                    self.end(ExerciseOutcome::Missed(reason));
                    return None;
                }
                if trip.is_some() || !sight.sounds || *paused {
                    *sounding_s = None;
                    let limit_s = if trip.is_some() || *paused {
                        PATIENCE_S
                    } else {
                        START_S
                    };
                    if waited_s > limit_s {
                        self.end(ExerciseOutcome::Missed(
                            "the drive did not begin".to_owned(),
                        ));
                    }
                    return None;
                }
                if now_s - *sounding_s.get_or_insert(now_s) < self.settle_s {
                    return None;
                }
                self.note = None;
                self.enter(
                    if self.is_manual {
                        Stage::Asked
                    } else {
                        Stage::Begun
                    },
                    now_s,
                );
                self.begun_s = now_s;
                (!self.is_manual).then_some(Order::Begin)
            }
            Stage::Asked => {
                match trip {
                    Some(Trip::Operator) => {
                        self.end(ExerciseOutcome::Missed(
                            "the operator's key stopped the drive first".to_owned(),
                        ));
                    }
                    Some(trip) if !is_sign(self.fault, trip) => {
                        self.end(stopped_by_another(trip));
                    }
                    Some(trip) => {
                        // The moment of the action is unknown: time counts from its detection by the bench.
                        self.begun_s = now_s;
                        self.sign = trip.to_string();
                        self.times.shown_s = Some(0.0);
                        self.noticed_s = now_s;
                        self.enter(Stage::Noticed, now_s);
                        self.note_silence(Some(trip), sight);
                    }
                    None if waited_s > PATIENCE_S => {
                        let reason = "nothing was done, or the bench did not see it";
                        self.end(ExerciseOutcome::Missed(reason.to_owned()));
                    }
                    None => {}
                }
                None
            }
            Stage::Begun => {
                self.look_for_the_fault(trip, sight, waited_s);
                None
            }
            Stage::Noticed => {
                if waited_s > PATIENCE_S {
                    self.end(ExerciseOutcome::Missed("nobody acknowledged it".to_owned()));
                }
                None
            }
            Stage::Acknowledged { rearming_s } => {
                if let Some(asked_s) = *rearming_s {
                    if *sight.safety == SafetyState::Disarmed {
                        self.times.rearmed_s = self.since_fault_s(now_s);
                        self.note = None;
                        self.enter(Stage::Rearmed, now_s);
                        return None;
                    }
                    if now_s - asked_s > REARMED_S {
                        *rearming_s = None;
                        self.note = Some("The cause is still there.");
                    }
                }
                if waited_s > PATIENCE_S {
                    self.end(ExerciseOutcome::Missed(
                        "the right action was not taken in time".to_owned(),
                    ));
                }
                None
            }
            Stage::Rearmed => {
                if waited_s > PATIENCE_S {
                    self.end(ExerciseOutcome::Missed("nobody resumed".to_owned()));
                }
                None
            }
            Stage::Resuming { sounding_s } => {
                if trip.is_some() {
                    self.note = Some("Stopped again: the cause is still there.");
                    self.enter(Stage::Acknowledged { rearming_s: None }, now_s);
                } else if !sight.sounds {
                    *sounding_s = None;
                    if waited_s > START_S {
                        self.end(ExerciseOutcome::Missed(
                            "the drive did not resume".to_owned(),
                        ));
                    }
                } else if now_s - *sounding_s.get_or_insert(now_s) >= RESUMED_S {
                    self.times.done_s = self.since_fault_s(now_s);
                    self.conclude();
                }
                None
            }
            Stage::Over(_) => None,
        }
    }

    fn look_for_the_fault(&mut self, trip: Option<&Trip>, sight: Sight<'_>, waited_s: f64) {
        let now_s = sight.now_s;
        let stops = self.fault.row().required != Required::Flag;
        let sign = match (trip, sight.flag) {
            (Some(Trip::Operator), _) => {
                self.end(ExerciseOutcome::Missed(
                    "the operator's key stopped the drive first".to_owned(),
                ));
                return;
            }
            (Some(trip), _) if stops && is_sign(self.fault, trip) => trip.to_string(),
            (Some(trip), _) if stops => {
                self.end(stopped_by_another(trip));
                return;
            }
            (Some(trip), _) => {
                self.end(should_have_gone_on(trip));
                return;
            }
            (None, Some(flag)) if !stops => flag.to_owned(),
            (None, _) => {
                if waited_s > UNSEEN_S.max(self.within_s) {
                    let failure = if stops {
                        "did not stop"
                    } else {
                        "flagged nothing"
                    };
                    self.end(ExerciseOutcome::Missed(format!("the bench {failure}")));
                }
                return;
            }
        };
        self.sign = sign;
        self.times.shown_s = self.since_fault_s(now_s);
        self.noticed_s = now_s;
        self.enter(Stage::Noticed, now_s);
        self.note_silence(trip, sight);
    }

    /// Records when the drive fell silent after the bench stopped it.
    fn note_silence(&mut self, trip: Option<&Trip>, sight: Sight<'_>) {
        let noticed = matches!(self.stage, Stage::Noticed | Stage::Acknowledged { .. });
        if trip.is_none() || !noticed || self.times.silent_s.is_some() {
            return;
        }
        // A card that renders no samples cannot report silence; its amplifier is off by then.
        let card_stopped = self.fault.row().row == Some(CARD);
        let disabled = card_stopped && sight.now_s - self.noticed_s >= DISABLED_S;
        if !sight.sounds || disabled {
            self.times.silent_s = self.since_fault_s(sight.now_s);
        }
    }

    /// Takes an action of the operator; returns the order to the bench.
    pub fn act(&mut self, action: Action, now_s: f64) -> Option<Order> {
        self.note = None;
        let remedy = self.fault.row().remedy;
        match (&mut self.stage, action) {
            (Stage::Noticed, _) => self.acknowledge(action, now_s),
            (Stage::Acknowledged { rearming_s }, Action::Rearm)
                if matches!(remedy, Remedy::Rearm(_)) =>
            {
                *rearming_s = Some(now_s);
                Some(Order::Rearm)
            }
            (Stage::Acknowledged { .. }, Action::Redo(_)) if remedy == Remedy::Repeat => {
                self.times.done_s = self.since_fault_s(now_s);
                self.conclude();
                None
            }
            (Stage::Acknowledged { .. }, Action::Quit) if matches!(remedy, Remedy::Restart(_)) => {
                self.times.done_s = self.since_fault_s(now_s);
                self.conclude();
                None
            }
            (Stage::Rearmed, Action::Resume) => {
                self.enter(Stage::Resuming { sounding_s: None }, now_s);
                Some(Order::Drive)
            }
            (Stage::Settling { paused, .. }, Action::EmergencyStop) => {
                *paused = true;
                self.note = Some("You stopped the drive: re-arm with x.");
                Some(Order::Stop)
            }
            (Stage::Resuming { .. } | Stage::Asked, Action::EmergencyStop) => Some(Order::Stop),
            (Stage::Settling { paused, .. }, Action::Pause) => {
                *paused = true;
                self.note = Some("Paused: resume with p.");
                Some(Order::Pause)
            }
            (Stage::Settling { paused, .. }, Action::Resume) => {
                *paused = false;
                Some(Order::Drive)
            }
            (Stage::Settling { paused, .. }, Action::Rearm) => {
                *paused = true;
                self.note = Some("Re-armed: resume with p.");
                Some(Order::Rearm)
            }
            (Stage::Settling { .. } | Stage::Begun | Stage::Asked, _) => {
                self.note = Some("Nothing has happened yet.");
                None
            }
            (Stage::Acknowledged { .. } | Stage::Rearmed, Action::EmergencyStop) => {
                self.note = Some("The drive is stopped already.");
                None
            }
            (Stage::Acknowledged { .. } | Stage::Rearmed, _) => {
                self.note = Some("This key does not help here.");
                None
            }
            (Stage::Resuming { .. } | Stage::Over(_), _) => None,
        }
    }

    /// Takes the operator's first response to the fault: any key that acknowledges it.
    fn acknowledge(&mut self, action: Action, now_s: f64) -> Option<Order> {
        let row = self.fault.row();
        self.times.seen_s = self.since_fault_s(now_s);
        self.enter(Stage::Acknowledged { rearming_s: None }, now_s);
        match (row.remedy, action) {
            (Remedy::Repeat, Action::Redo(_)) | (Remedy::Restart(_), Action::Quit) => {
                self.act(action, now_s)
            }
            (Remedy::Rearm(_), Action::Rearm) if !self.is_manual => {
                self.note = Some("The cause was still there; it is removed now.");
                Some(Order::End)
            }
            (Remedy::Rearm(_), Action::Rearm) => self.act(action, now_s),
            (Remedy::Rearm(_), _) => (!self.is_manual).then_some(Order::End),
            _ => None,
        }
    }

    /// Handles the end of the bench: the exercise is missed, unless the bench has shown the fault and the remedy ends the bench
    /// anyway; it then continues without a bench.
    pub fn bench_ended(&mut self, reason: &str) {
        let is_noticed = matches!(self.stage, Stage::Noticed | Stage::Acknowledged { .. });
        let ends_anyway = matches!(self.fault.row().remedy, Remedy::Restart(_));
        if self.outcome().is_none() && !(is_noticed && ends_anyway) {
            self.end(ExerciseOutcome::Missed(format!(
                "the bench ended: {reason}"
            )));
        }
    }

    /// Returns the time since the fault, s, rounded to 1 µs.
    fn since_fault_s(&self, now_s: f64) -> Option<f64> {
        Some((1e6 * (now_s - self.begun_s)).round() / 1e6)
    }

    fn enter(&mut self, stage: Stage, now_s: f64) {
        self.stage = stage;
        self.since_s = Some(now_s);
    }

    /// Ends an exercise after all steps: met if in time.
    fn conclude(&mut self) {
        let stops = self.fault.row().required != Required::Flag;
        let late_s = self
            .times
            .silent_s
            .filter(|silent_s| *silent_s > self.within_s);
        let outcome = match (stops, self.times.silent_s, late_s) {
            (true, None, _) => ExerciseOutcome::Missed("the drive was never silent".to_owned()),
            (true, _, Some(late_s)) => ExerciseOutcome::Missed(format!(
                "the drive was silent only after {:.0} ms, more than {:.0} ms",
                1e3 * late_s,
                1e3 * self.within_s
            )),
            _ => ExerciseOutcome::Met,
        };
        self.end(outcome);
    }

    fn end(&mut self, outcome: ExerciseOutcome) {
        self.note = None;
        self.stage = Stage::Over(outcome);
    }
}

fn stopped_by_another(trip: &Trip) -> ExerciseOutcome {
    ExerciseOutcome::Missed(format!("the bench stopped for another reason: {trip}"))
}

fn should_have_gone_on(trip: &Trip) -> ExerciseOutcome {
    ExerciseOutcome::Missed(format!(
        "the bench stopped, and should have gone on: {trip}"
    ))
}

#[cfg(test)]
mod tests;
