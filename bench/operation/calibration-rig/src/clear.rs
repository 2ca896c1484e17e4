//! Measurements of the bare plate: captures with a load on the plate are rejected.

use anyhow::bail;
use jiff::Timestamp;

use crate::capture::Capture;
use crate::judged::{Calibrates, Judged};
use crate::operator::{CalibrationProgress, Request};
use crate::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;

/// Length of the silence in which the force sensor is read, s.
pub const LISTEN_S: f64 = 0.3;

/// A procedure `P` that receives only captures of the bare plate. The operator is asked to clear the plate before the first
/// drive and whenever a load rests on it, and the step is repeated; without an operator, the measurement ends.
pub struct ClearPlate<P> {
    procedure: P,
    zero_n: f64,
    attended: bool,
    step: NextStep,
    reason: Option<Asked>,
}

/// Reason why the operator was asked to clear the plate.
#[derive(Clone, Copy)]
enum Asked {
    /// The plate is about to be driven.
    Beginning,
    /// The force sensor reads this normal force, N.
    Resting(f64),
}

impl<P> ClearPlate<P> {
    /// Wraps `procedure` on the bench of `config`; `attended` means that an operator can be asked.
    pub fn new(procedure: P, config: &Config, attended: bool) -> Self {
        Self {
            procedure,
            zero_n: config.calibration.zero_n,
            attended,
            step: NextStep::Listen(LISTEN_S),
            reason: None,
        }
    }

    /// Returns the wrapped procedure.
    pub fn inner(&self) -> &P {
        &self.procedure
    }

    fn resting(&self, capture: &Capture) -> Option<f64> {
        capture
            .mean_force_n()
            .map(|(normal_n, _)| normal_n)
            .filter(|normal_n| normal_n.abs() > self.zero_n)
    }
}

impl<P: Procedure> Procedure for ClearPlate<P> {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        let resting_n = match (&outcome, &self.step) {
            (StepOutcome::Captured(capture), _)
            | (StepOutcome::Answered(_, capture), NextStep::Sound(..)) => self.resting(capture),
            _ => None,
        };
        if self.attended && matches!(outcome, StepOutcome::Began) {
            self.step = self.procedure.next(outcome)?;
            self.reason = Some(Asked::Beginning);
            return Ok(NextStep::Ask(Request::Unload));
        }
        let is_asking = self.reason.is_some();
        match (resting_n, &outcome) {
            (Some(normal_n), _) if !self.attended => bail!(
                "something rests on the plate: the force sensor reads {normal_n:.3} N, more than calibration.zero_n = {} N; remove the finger and everything else, or run `friction-bench calibrate force`",
                self.zero_n
            ),
            // The force sensor decides whether the plate is clear.
            (_, StepOutcome::Answered(..)) if is_asking => return Ok(NextStep::Listen(LISTEN_S)),
            (Some(normal_n), _) => {
                self.reason = Some(Asked::Resting(normal_n));
                return Ok(NextStep::Ask(Request::Unload));
            }
            (None, StepOutcome::Captured(_)) if is_asking => {
                self.reason = None;
                return Ok(self.step.clone());
            }
            (None, _) => {}
        }
        self.step = self.procedure.next(outcome)?;
        Ok(self.step.clone())
    }

    fn progress(&self) -> CalibrationProgress {
        let mut progress = self.procedure.progress();
        progress.note = match self.reason {
            None => progress.note,
            Some(Asked::Beginning) => Some(
                "The plate is driven next: do not touch it until the measurement is over."
                    .to_owned(),
            ),
            Some(Asked::Resting(normal_n)) => Some(format!(
                "Something rests on the plate: the force sensor read {normal_n:.3} N, more than calibration.zero_n = {} N. This reading is rejected and repeated. If nothing is there, quit and run `friction-bench calibrate force`.",
                self.zero_n
            )),
        };
        progress
    }
}

impl<P: Calibrates> Calibrates for ClearPlate<P> {
    const NAME: &'static str = P::NAME;

    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged> {
        self.procedure.judge(date, operator)
    }

    fn judge_review(&self) -> anyhow::Result<Judged> {
        self.procedure.judge_review()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Answer;

    /// Counts the captures that it receives.
    #[derive(Default)]
    struct Counts(u32);

    impl Procedure for Counts {
        fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
            self.0 += u32::from(matches!(outcome, StepOutcome::Captured(_)));
            Ok(NextStep::Listen(7.0))
        }

        fn progress(&self) -> CalibrationProgress {
            CalibrationProgress::default()
        }
    }

    fn capture_under(normal_n: f64) -> Capture {
        Capture {
            normal_n: vec![normal_n],
            lateral_n: vec![0.0],
            ..Capture::default()
        }
    }

    fn clear(attended: bool) -> ClearPlate<Counts> {
        let config = Config::parse(config::rigs::MOCK_BENCH, "test").unwrap();
        let mut clear = ClearPlate::new(Counts::default(), &config, attended);
        let next = clear.next(StepOutcome::Began).unwrap();
        if attended {
            assert!(matches!(next, NextStep::Ask(Request::Unload)), "{next:?}");
            assert!(clear.progress().note.unwrap().contains("driven"));
            let done = StepOutcome::Answered(Answer::Ready, capture_under(0.5));
            assert!(matches!(clear.next(done).unwrap(), NextStep::Listen(s) if s == LISTEN_S));
            clear
                .next(StepOutcome::Captured(capture_under(0.0)))
                .unwrap();
        }
        clear
    }

    #[test]
    fn a_step_under_a_finger_is_made_again_once_the_plate_is_clear() {
        let mut clear = clear(true);
        let next = clear
            .next(StepOutcome::Captured(capture_under(0.5)))
            .unwrap();
        assert!(matches!(next, NextStep::Ask(Request::Unload)), "{next:?}");
        assert!(clear.progress().note.unwrap().contains("0.500 N"));
        let done = || StepOutcome::Answered(Answer::Ready, capture_under(0.5));
        let next = clear.next(done()).unwrap();
        assert!(
            matches!(next, NextStep::Listen(s) if s == LISTEN_S),
            "{next:?}"
        );
        let next = clear
            .next(StepOutcome::Captured(capture_under(0.4)))
            .unwrap();
        assert!(matches!(next, NextStep::Ask(Request::Unload)), "{next:?}");
        clear.next(done()).unwrap();
        let next = clear
            .next(StepOutcome::Captured(capture_under(0.0)))
            .unwrap();
        assert!(matches!(next, NextStep::Listen(s) if s == 7.0), "{next:?}");
        assert_eq!(clear.procedure.0, 0, "nothing of it was used");
        clear
            .next(StepOutcome::Captured(capture_under(0.0)))
            .unwrap();
        assert_eq!(clear.procedure.0, 1);
        assert!(clear.progress().note.is_none());
    }

    #[test]
    fn without_an_operator_the_calibration_ends() {
        let error = clear(false)
            .next(StepOutcome::Captured(capture_under(0.5)))
            .unwrap_err()
            .to_string();
        assert!(error.contains("something rests on the plate"), "{error}");
    }
}
