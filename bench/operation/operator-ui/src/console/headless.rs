//! Progress as lines of text, for scripts and logs.

use std::io::Write;

use tui::action::AttemptName;
use tui::event::{LogLevel, PhaseKind};
use tui::{Action, Event};

use crate::console::front::Front;

/// A front end that prints progress as lines of text, for scripts and logs. It returns no actions: the protocol's own
/// rules decide.
///
/// ```
/// use operator_ui::console::{Front, Headless};
/// use tui::Event;
/// use tui::event::LogLevel;
///
/// let mut text = Vec::new();
/// let mut front = Headless::new(&mut text);
/// front.show(Event::Log { level: LogLevel::Warning, text: "normal forces saturated: 3".to_owned() });
/// assert!(front.action().is_none());
/// assert_eq!(text, b"  warning: normal forces saturated: 3\n");
/// ```
pub struct Headless<W> {
    out: W,
    unread: bool,
    phase: Option<(PhaseKind, u32, u32)>,
    tripped: Option<String>,
    /// Rejected attempt of which the phase has yet to say whether it is repeated.
    rejected: Option<AttemptName>,
}

impl<W: Write> Headless<W> {
    /// Creates a front end that prints to `out`.
    pub fn new(out: W) -> Self {
        Self {
            out,
            unread: false,
            phase: None,
            tripped: None,
            rejected: None,
        }
    }

    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        // A closed output does not end a session; a caller that runs only for this output checks `is_unread`.
        let text = text.to_string();
        self.unread |= writeln!(self.out, "{}", escaping::escaped_line(&text)).is_err();
    }
}

impl<W: Write + Send> Front for Headless<W> {
    fn show(&mut self, event: Event) {
        match event {
            Event::Phase(phase) => {
                let phase_key = (phase.kind, phase.trial, phase.attempt);
                let sort = if phase.practice { "practice" } else { "trial" };
                if phase.kind == PhaseKind::Baseline
                    && phase.trial > 0
                    && self.phase != Some(phase_key)
                {
                    let attempt_text = if phase.attempt > 1 {
                        format!(", attempt {}", phase.attempt)
                    } else {
                        String::new()
                    };
                    self.line(format_args!(
                        "{sort} {} of {}{attempt_text}",
                        phase.trial, phase.trials
                    ));
                }
                self.phase = Some(phase_key);
                let is_judged = |rejected: &mut AttemptName| {
                    phase.kind == PhaseKind::Verdict && *rejected == phase.name()
                };
                if self.rejected.take_if(is_judged).is_some() && !phase.repeats {
                    self.line(format_args!("  given up: no repetition is left"));
                }
            }
            Event::Verdict(verdict) => {
                let force = verdict
                    .mean_normal_n
                    .map(|n| format!(", mean force {n:.2} N"))
                    .unwrap_or_default();
                if verdict.accepted {
                    self.line(format_args!(
                        "  accepted: {} instances{force}",
                        verdict.instances
                    ));
                } else if verdict.interrupted {
                    let reason = verdict
                        .settled
                        .as_deref()
                        .unwrap_or("for an unknown reason");
                    self.line(format_args!("  {} interrupted: {reason}", verdict.name()));
                } else {
                    let decision = verdict.settled.clone();
                    let reasons: Vec<String> = decision
                        .into_iter()
                        .chain(verdict.reasons.clone())
                        .collect();
                    // The rules repeat no practice.
                    let word = if verdict.practice && verdict.settled.is_none() {
                        "not passed"
                    } else {
                        "again"
                    };
                    if verdict.settled.is_none() && !verdict.practice {
                        self.rejected = Some(verdict.name());
                    }
                    self.line(format_args!("  {word}: {}{force}", reasons.join("; ")));
                }
            }
            Event::Safety {
                state: tui::event::SafetyView::Tripped,
                reason,
            } if self.tripped != reason => {
                self.tripped = reason;
                let reason = self.tripped.clone().unwrap_or_default();
                self.line(format_args!("  STOPPED: {reason}"));
            }
            Event::Fit(fit) => {
                for line in &fit.details {
                    self.line(format_args!("  {line}"));
                }
            }
            Event::Log { level, text } => match level {
                LogLevel::Info => self.line(format_args!("  {text}")),
                LogLevel::Warning => self.line(format_args!("  warning: {text}")),
                LogLevel::Error => self.line(format_args!("  error: {text}")),
            },
            _ => {}
        }
    }

    fn action(&mut self) -> Option<Action> {
        None
    }

    fn is_unread(&self) -> bool {
        self.unread
    }
}

#[cfg(test)]
mod tests {
    use tui::event::{PhaseView, TrialVerdict};

    use super::*;

    #[test]
    fn a_rejected_trial_without_a_repetition_is_given_up() {
        let lines = |repeats: bool| {
            let mut text = Vec::new();
            let mut headless = Headless::new(&mut text);
            headless.show(Event::Verdict(TrialVerdict {
                trial: 2,
                attempt: 4,
                reasons: vec!["2 instances, 5 needed".to_owned()],
                ..TrialVerdict::default()
            }));
            for _ in 0..2 {
                headless.show(Event::Phase(PhaseView {
                    kind: PhaseKind::Verdict,
                    trial: 2,
                    attempt: 4,
                    repeats,
                    trials: 3,
                    practice: false,
                    exploration: 0,
                    explorations: 1,
                    countdown: None,
                    condition: None,
                    message: None,
                    pausing: false,
                    overrulable: true,
                    stopped: false,
                    aborted: false,
                }));
            }
            String::from_utf8(text).unwrap()
        };
        assert_eq!(lines(true), "  again: 2 instances, 5 needed\n");
        assert_eq!(
            lines(false),
            "  again: 2 instances, 5 needed\n  given up: no repetition is left\n"
        );
    }

    #[test]
    fn every_verdict_has_its_reason() {
        let line = |verdict: TrialVerdict| {
            let mut text = Vec::new();
            Headless::new(&mut text).show(Event::Verdict(verdict));
            String::from_utf8(text).unwrap()
        };
        let verdict = TrialVerdict {
            trial: 2,
            practice: true,
            attempt: 1,
            ..TrialVerdict::default()
        };
        let interruption = TrialVerdict {
            interrupted: true,
            settled: Some("the program ended".to_owned()),
            ..verdict.clone()
        };
        assert_eq!(
            line(interruption),
            "  practice 2 interrupted: the program ended\n"
        );
        let repetition = TrialVerdict {
            settled: Some("repeated by the operator".to_owned()),
            mean_normal_n: Some(0.6),
            ..verdict
        };
        assert_eq!(
            line(repetition),
            "  again: repeated by the operator, mean force 0.60 N\n"
        );
    }
}
