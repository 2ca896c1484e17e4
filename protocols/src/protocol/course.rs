//! Course of a session: its trials and rests in time.

use super::definition::Protocol;

/// A session without repetitions, with the times assumed for the participant.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Steps in order.
    pub steps: Vec<CourseStep>,
    /// End of the last step, s.
    pub end_s: f64,
}

/// Trials without a rest between them, or a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseStep {
    /// Start, s after the first trial's.
    pub start_s: f64,
    /// Kind of the step.
    pub kind: StepKind,
}

/// Kind of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepKind {
    /// Practice trials, by the numbers of the first and the last.
    Practice(u32, u32),
    /// Trials, by the numbers of the first and the last.
    Trials(u32, u32),
    /// A rest of this length at least, s.
    Rest(f64),
}

impl Protocol {
    /// Returns the course of a session.
    ///
    /// ```
    /// use protocols::{Protocol, StepKind, built_in};
    ///
    /// let text = built_in("huloux2021").expect("a built-in protocol");
    /// let course = Protocol::parse(text, "huloux2021.toml")?.course();
    /// let kinds: Vec<_> = course.steps.iter().map(|step| step.kind).collect();
    /// assert_eq!(
    ///     kinds,
    ///     [
    ///         StepKind::Practice(1, 2),
    ///         StepKind::Trials(1, 5),
    ///         StepKind::Rest(60.0),
    ///         StepKind::Trials(6, 10),
    ///     ]
    /// );
    /// // Twelve trials of 30.4 s with verdicts of 2 s, and the rest.
    /// assert!((course.end_s - (12.0 * 32.4 + 60.0)).abs() < 1e-9);
    /// # Ok::<(), protocols::ProtocolError>(())
    /// ```
    pub fn course(&self) -> Course {
        let driving = self.driving_time();
        let practice = self.trials.practice;
        let mut steps: Vec<CourseStep> = Vec::new();
        let starts_s = self.starts_s(driving.trials, driving.trial_s);
        for (trial, &start_s) in (0..).zip(&starts_s) {
            if self.rest.is_due_after(trial, practice) {
                steps.push(CourseStep {
                    start_s: start_s - self.rest.min_s,
                    kind: StepKind::Rest(self.rest.min_s),
                });
            }
            let extended = match steps.last_mut().map(|step| &mut step.kind) {
                Some(StepKind::Practice(_, last)) if trial < practice => Some(last),
                Some(StepKind::Trials(_, last)) => Some(last),
                _ => None,
            };
            if let Some(last) = extended {
                *last += 1;
                continue;
            }
            let kind = if trial < practice {
                StepKind::Practice(1, 1)
            } else {
                let number = trial - practice + 1;
                StepKind::Trials(number, number)
            };
            steps.push(CourseStep { start_s, kind });
        }
        let last_s = starts_s.last().copied().unwrap_or(0.0);
        Course {
            steps,
            end_s: last_s + driving.trial_s + self.timing.verdict_s,
        }
    }
}
