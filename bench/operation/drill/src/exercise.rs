//! One exercise: a fault, the response of bench and operator, and its times. Free of side effects: the next order depends only
//! on the observations and the operator's actions.

mod instruction;
mod observation;
mod response;
mod sight;

use faults::{FaultKind, Remedy, Required};

use crate::times::{ExerciseOutcome, Times};

pub(crate) use sight::{Order, Sight};

/// Time limit for the bench to stop or flag a fault, s.
const UNSEEN_S: f64 = 2.0;

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

    /// Handles the end of the bench: the exercise is missed, unless the bench has shown the fault and the remedy ends the bench
    /// anyway; it then continues without a bench.
    pub fn bench_ended(&mut self, reason: &str) {
        let ends_anyway = matches!(self.fault.row().remedy, Remedy::Restart(_));
        if self.outcome().is_none() && !(self.is_noticed() && ends_anyway) {
            self.miss(format!("the bench ended: {reason}"));
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

    /// Returns whether the bench has shown the fault, and the remedy is not yet complete.
    fn is_noticed(&self) -> bool {
        matches!(self.stage, Stage::Noticed | Stage::Acknowledged { .. })
    }

    /// Returns whether the fault must stop the drive, rather than be flagged.
    fn must_stop(&self) -> bool {
        self.fault.row().required != Required::Flag
    }

    /// Ends an exercise after all steps: met if the drive was silent in time.
    fn complete(&mut self, now_s: f64) {
        self.times.done_s = self.since_fault_s(now_s);
        match self.times.silent_s {
            None if self.must_stop() => self.miss("the drive was never silent"),
            Some(late_s) if self.must_stop() && late_s > self.within_s => self.miss(format!(
                "the drive was silent only after {:.0} ms, more than {:.0} ms",
                1e3 * late_s,
                1e3 * self.within_s
            )),
            _ => self.end(ExerciseOutcome::Met),
        }
    }

    fn miss(&mut self, reason: impl Into<String>) {
        self.end(ExerciseOutcome::Missed(reason.into()));
    }

    fn end(&mut self, outcome: ExerciseOutcome) {
        self.note = None;
        self.stage = Stage::Over(outcome);
    }
}

#[cfg(test)]
mod tests;
