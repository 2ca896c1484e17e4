//! Review of a calibration: its results are shown before they are put in force, and results that do not pass are asked about.

use config::{CalibrationFile, Config};
use jiff::Timestamp;

use crate::constant_change::{ConstantChange, changes};
use crate::judged::{Calibrates, Judged};
use crate::operator::{Answer, CalibrationProgress, Request};
use crate::procedure::{NextStep, Procedure, StepOutcome};

/// A procedure `P` with reviews that show its results. If they do not pass, the operator who accepts them is asked once more,
/// because the points would be lost.
pub struct ReviewProcedure<P> {
    procedure: P,
    /// Whether an operator can measure a point again.
    attended: bool,
    in_force: CalibrationFile,
    configured: Config,
    review: Option<Review>,
}

/// Results under review.
#[derive(Debug, Default)]
struct Review {
    /// Results, a line each.
    lines: Vec<String>,
    /// Reasons to reject the results.
    faults: Vec<String>,
    /// Whether the operator has accepted results that do not pass, and was asked about them.
    is_asked_again: bool,
}

impl Review {
    /// Creates the review of an outcome, compared with the calibration in force and with the configured constants.
    fn new(
        outcome: anyhow::Result<Judged>,
        in_force: &CalibrationFile,
        configured: &Config,
    ) -> Self {
        let judged = match outcome {
            Ok(judged) => judged,
            Err(error) => {
                return Self {
                    faults: vec![bounded_files::cause_line(error.as_ref())],
                    ..Self::default()
                };
            }
        };
        let values = judged.values.iter();
        let values = values.map(|(name, quantity)| format!("{name} {quantity}"));
        let changes = changes(&judged.part, in_force, configured);
        let changes = changes.iter().map(ConstantChange::in_words);
        let remarks = judged.remarks.iter().map(|remark| {
            let words = remark.split_whitespace();
            words.collect::<Vec<_>>().join(" ")
        });
        // The note has the first reason.
        let further = judged.faults.iter().skip(1);
        let faults = further.map(|fault| format!("FAILED {fault}"));
        Self {
            lines: faults.chain(changes).chain(values).chain(remarks).collect(),
            faults: judged.faults,
            is_asked_again: false,
        }
    }

    /// Returns the note on results that do not pass.
    fn note(&self) -> Option<String> {
        let fault = self.faults.first()?;
        Some(if self.is_asked_again {
            format!(
                "These results do not pass and cannot be put in force: {fault}. r measures the selected point again and keeps \
                 the others; Enter once more ends the calibration, and leaves the points in its CSV file."
            )
        } else {
            fault.clone()
        })
    }
}

impl<P: Calibrates> ReviewProcedure<P> {
    /// Wraps `procedure`; its results are compared with the calibration `in_force` and with the `configured` constants.
    /// `attended` means that an operator can be asked.
    pub fn new(
        procedure: P,
        attended: bool,
        in_force: CalibrationFile,
        configured: Config,
    ) -> Self {
        Self {
            procedure,
            attended,
            in_force,
            configured,
            review: None,
        }
    }
}

impl<P: Calibrates> Procedure for ReviewProcedure<P> {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        if let Some(review) = &mut self.review
            && matches!(outcome, StepOutcome::Answered(Answer::Ready, _))
            && self.attended
            && !review.faults.is_empty()
            && !review.is_asked_again
        {
            review.is_asked_again = true;
            return Ok(NextStep::Ask(Request::Review));
        }
        let step = self.procedure.next(outcome)?;
        let is_review = matches!(step, NextStep::Ask(Request::Review));
        self.review = is_review.then(|| {
            let outcome = self.procedure.judge_review();
            Review::new(outcome, &self.in_force, &self.configured)
        });
        Ok(step)
    }

    fn progress(&self) -> CalibrationProgress {
        let progress = self.procedure.progress();
        let Some(review) = &self.review else {
            return progress;
        };
        let note = progress.note.filter(|_| !review.is_asked_again);
        CalibrationProgress {
            note: note.or_else(|| review.note()),
            findings: review.lines.clone(),
            rejected: !review.faults.is_empty(),
            ..progress
        }
    }
}

impl<P: Calibrates> Calibrates for ReviewProcedure<P> {
    const NAME: &'static str = P::NAME;
    const DRIVES_A_FINGER: bool = P::DRIVES_A_FINGER;

    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged> {
        self.procedure.judge(date, operator)
    }
}

#[cfg(test)]
mod tests {
    use anyhow::bail;

    use super::*;
    use crate::capture::Capture;

    /// Is reviewed at once; its only point is right or wrong.
    struct OnePoint {
        is_right: bool,
        is_done: bool,
    }

    impl Procedure for OnePoint {
        fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
            self.is_done = matches!(outcome, StepOutcome::Answered(Answer::Ready, _));
            self.is_right |= matches!(outcome, StepOutcome::Answered(Answer::Redo(_), _));
            Ok(if self.is_done {
                NextStep::Done
            } else {
                NextStep::Ask(Request::Review)
            })
        }

        fn progress(&self) -> CalibrationProgress {
            CalibrationProgress::default()
        }
    }

    impl Calibrates for OnePoint {
        const NAME: &'static str = "one point";

        fn judge(&self, _: Timestamp, _: &str) -> anyhow::Result<Judged> {
            bail!("the point is off")
        }

        fn judge_review(&self) -> anyhow::Result<Judged> {
            if !self.is_right {
                return self.judge(Timestamp::UNIX_EPOCH, "");
            }
            let config = Config::parse(config::rigs::MOCK_BENCH, "test")?;
            Ok(Judged {
                part: crate::judged::tests::pickup_part(&config),
                values: vec![("slope", config::Quantity::new(2.0, 0.0, 1, "V"))],
                remarks: vec!["noise            low".to_owned()],
                faults: Vec::new(),
                stem: Self::NAME,
                table: String::new(),
                figure: None,
                side_files: Vec::new(),
            })
        }
    }

    fn reviewed(attended: bool) -> ReviewProcedure<OnePoint> {
        let point = OnePoint {
            is_right: false,
            is_done: false,
        };
        let config = Config::parse(config::rigs::MOCK_BENCH, "test").unwrap();
        let identity = config::Identity::from_config(&config, String::new(), String::new());
        let in_force = CalibrationFile::new(identity);
        let mut reviewed = ReviewProcedure::new(point, attended, in_force, config);
        reviewed.next(StepOutcome::Began).unwrap();
        reviewed
    }

    fn answer(answer: Answer) -> StepOutcome {
        StepOutcome::Answered(answer, Capture::default())
    }

    #[test]
    fn results_that_do_not_pass_are_asked_about_and_a_point_can_be_repeated() {
        let mut reviewed = reviewed(true);
        assert!(reviewed.progress().rejected);
        let step = reviewed.next(answer(Answer::Ready)).unwrap();
        assert!(matches!(step, NextStep::Ask(Request::Review)), "{step:?}");
        let note = reviewed.progress().note.unwrap();
        assert!(
            note.contains("the point is off") && note.contains("Enter once more"),
            "{note}"
        );
        reviewed.next(answer(Answer::Redo(0))).unwrap();
        let progress = reviewed.progress();
        assert!(
            !progress.rejected && progress.note.is_none(),
            "{progress:?}"
        );
        let [change, results @ ..] = &progress.findings[..] else {
            panic!("no results");
        };
        assert!(
            change.contains("is 1.0000 times the configured one"),
            "{change}"
        );
        assert_eq!(results, ["slope 2.000000 V", "noise low"]);
        let step = reviewed.next(answer(Answer::Ready)).unwrap();
        assert!(matches!(step, NextStep::Done), "{step:?}");
    }

    #[test]
    fn results_that_do_not_pass_end_at_the_second_time_or_unattended() {
        let mut twice = reviewed(true);
        twice.next(answer(Answer::Ready)).unwrap();
        assert!(matches!(
            twice.next(answer(Answer::Ready)).unwrap(),
            NextStep::Done
        ));
        let mut unattended = reviewed(false);
        assert!(matches!(
            unattended.next(answer(Answer::Ready)).unwrap(),
            NextStep::Done
        ));
    }
}
