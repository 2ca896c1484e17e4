//! Remaining time and next steps of a session.

use protocols::{Phase, Progress, Session};

/// Follows a session to predict its remaining time.
#[derive(Debug, Default)]
pub struct OutlookTracker {
    /// Start of the running attempt, s.
    began_s: Option<f64>,
    /// Times from the start of each attempt to the start of the next, s, for attempts neither broken off nor followed by a
    /// rest.
    attempts_s: Vec<f64>,
    last_outlook: Option<tui::event::Outlook>,
}

impl OutlookTracker {
    /// Marks the start of an attempt.
    pub fn begin(&mut self, now_s: f64) {
        self.began_s = Some(now_s);
    }

    /// Marks the verdict on the running attempt.
    pub fn judged(&mut self, now_s: f64) {
        self.attempts_s
            .extend(self.began_s.take().map(|began_s| now_s - began_s));
    }

    /// Marks the end of the running attempt without a verdict.
    pub fn broken_off(&mut self) {
        self.began_s = None;
    }

    /// Returns the outlook if it has changed; the remaining time is rounded to 5 s.
    pub fn update(
        &mut self,
        session: &Session,
        progress: Option<&Progress>,
        now_s: f64,
    ) -> Option<tui::event::Outlook> {
        let outlook = self.outlook(session, progress, now_s);
        if self.last_outlook.as_ref() == Some(&outlook) {
            return None;
        }
        self.last_outlook = Some(outlook.clone());
        Some(outlook)
    }

    fn outlook(
        &self,
        session: &Session,
        progress: Option<&Progress>,
        now_s: f64,
    ) -> tui::event::Outlook {
        let protocol = session.protocol();
        let trials_left = session.trials_left();
        let planned = protocol.planned_trials();
        let settled = planned - trials_left;
        let trial_s = self.trial_s(session);
        let elapsed_s = match (self.began_s, session.phase()) {
            (Some(began_s), _) => (now_s - began_s).min(trial_s),
            // An attempt that settles its trial counts until the next one begins.
            (None, Phase::Verdict) if !session.verdict_repeats() => {
                (trial_s - session.verdict_left_s().unwrap_or_default()).max(0.0)
            }
            (None, Phase::Saving) => trial_s,
            (None, _) => 0.0,
        };
        let rests = (settled + 1..planned)
            .filter(|settled| rests_after(session, *settled))
            .count();
        let left_s =
            f64::from(trials_left) * trial_s - elapsed_s + rests as f64 * protocol.rest.min_s;
        let (repetitions_of_trial, repetitions_in_session) = session.repetitions_left();
        let (next, then) = steps(session, progress);
        tui::event::Outlook {
            left_s: (left_s.max(0.0) / 5.0).round() * 5.0,
            trials_left,
            repetitions_of_trial,
            repetitions_in_session,
            next,
            then,
        }
    }

    /// Returns the time per trial: the mean of the session so far, or at first the protocol's assumption.
    fn trial_s(&self, session: &Session) -> f64 {
        let timing = &session.protocol().timing;
        if self.attempts_s.is_empty() {
            return session.protocol().driving_time().trial_s + timing.verdict_s;
        }
        let mean_s = self.attempts_s.iter().sum::<f64>() / self.attempts_s.len() as f64;
        mean_s + timing.verdict_s
    }
}

/// Returns whether a rest follows once `settled` trials, including practice, are settled.
fn rests_after(session: &Session, settled: u32) -> bool {
    let protocol = session.protocol();
    let rest = protocol.rest;
    settled < protocol.planned_trials() && rest.is_due_after(settled, protocol.trials.practice)
}

/// Returns the next two steps.
fn steps(session: &Session, progress: Option<&Progress>) -> (Option<String>, Option<String>) {
    let protocol = session.protocol();
    let (number, next) = session.next_numbers();
    let directions = &protocol.exploration.directions;
    let count = directions.len();
    let current = progress.map_or(0, |progress| progress.exploration.max(1) as usize - 1);
    let exploration = |index: usize| {
        let direction = directions.get(index)?;
        Some(format!("exploration {} of {count}, {direction}", index + 1))
    };
    let trial = |number: u32| {
        let practice = protocol.trials.practice;
        if number > protocol.planned_trials() {
            "the end of the session".to_owned()
        } else if number <= practice {
            format!("practice {number} of {practice}")
        } else {
            let planned = protocol.planned_trials() - practice;
            format!("trial {} of {planned}", number - practice)
        }
    };
    let step_after_trial = || {
        let settled = protocol.planned_trials() - session.trials_left();
        if rests_after(session, settled + 1) {
            format!("a rest of {:.0} s", protocol.rest.min_s)
        } else {
            trial(next)
        }
    };
    let step = |words: &str| Some(words.to_owned());
    match session.phase() {
        Phase::Consent => (step("the welcome"), Some(trial(number))),
        Phase::Welcome | Phase::Hold => {
            (step("the plate is driven without a finger"), exploration(0))
        }
        Phase::Baseline => (step("the finger is placed"), exploration(0)),
        Phase::Ready => (step("the countdown"), exploration(current)),
        Phase::Countdown => (exploration(current), step("the finger lifts")),
        Phase::Exploration => (step("the finger lifts"), step("its mean force is shown")),
        Phase::Lift => (
            step("its mean force is shown"),
            exploration(current + 1).or_else(|| step("the verdict")),
        ),
        Phase::Feedback => match exploration(current + 1) {
            Some(next) => (Some(next), None),
            None => (step("the verdict"), Some(step_after_trial())),
        },
        Phase::Analysing => (step("the verdict"), Some(step_after_trial())),
        Phase::Verdict if session.verdict_repeats() => {
            (Some(format!("{} again", trial(number))), None)
        }
        Phase::Verdict => (Some(step_after_trial()), None),
        Phase::Saving => (step("the recording is saved"), None),
        Phase::Rest => (Some(trial(number)), None),
        Phase::Paused | Phase::Fault if session.is_judged() && !session.verdict_repeats() => {
            (Some(step_after_trial()), None)
        }
        Phase::Paused | Phase::Fault => (Some(trial(number)), None),
        Phase::Finished | Phase::Aborted => (None, None),
    }
}

#[cfg(test)]
mod tests {
    use protocols::{Protocol, RedoReason, TrialKey, TrialOutcome, TrialRecord, built_in};

    use super::*;

    fn resume(records: &[TrialRecord]) -> Session {
        let protocol = Protocol::parse(built_in("demo").unwrap(), "demo.toml").unwrap();
        Session::resume(protocol, "sub-01".parse().unwrap(), 2021, records).unwrap()
    }

    /// Returns an attempt at a trial of a session with only one condition so far.
    fn trial_record(number: u32, attempt: u32, outcome: TrialOutcome) -> TrialRecord {
        TrialRecord {
            key: TrialKey {
                number,
                attempt,
                practice: number == 1,
                condition: resume(&[]).protocol().conditions[0].name.clone(),
            },
            outcome,
            analysis: None,
        }
    }

    #[test]
    fn trials_rests_and_repetitions_that_are_left_are_counted() {
        let redo = || TrialOutcome::Redo {
            reasons: vec![RedoReason::NotAnalysed],
        };
        let mut tracker = OutlookTracker::default();
        let start = tracker.update(&resume(&[]), None, 0.0).unwrap();
        let session = resume(&[
            trial_record(1, 1, TrialOutcome::Accepted),
            trial_record(2, 1, redo()),
            trial_record(2, 2, TrialOutcome::Accepted),
            trial_record(3, 1, redo()),
        ]);
        let advanced = tracker.update(&session, None, 0.0).unwrap();
        let limits = session.protocol().redo;
        assert_eq!(start.trials_left, session.protocol().planned_trials());
        assert_eq!(advanced.trials_left, start.trials_left - 2);
        assert_eq!(start.repetitions_in_session, limits.max_total);
        assert_eq!(advanced.repetitions_in_session, limits.max_total - 2);
        assert_eq!(advanced.repetitions_of_trial, limits.max_per_trial - 1);
        assert_eq!(advanced.then.as_deref(), Some("trial 2 of 4"));
        assert!(advanced.left_s < start.left_s);
        assert_eq!(tracker.update(&session, None, 0.0), None, "shown already");
    }

    #[test]
    fn the_time_left_goes_by_how_long_trials_take() {
        let session = resume(&[]);
        let left_s = |trial_s: f64| {
            let mut tracker = OutlookTracker::default();
            tracker.begin(0.0);
            tracker.judged(trial_s);
            tracker.update(&session, None, trial_s).unwrap().left_s
        };
        let trials = f64::from(session.protocol().planned_trials());
        assert!((left_s(60.0) - left_s(20.0) - 40.0 * trials).abs() <= 5.0);
    }
}
