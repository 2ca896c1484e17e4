//! What is left of a session, and what comes next.

use protocols::{Phase, Progress, Session, TrialOutcome};

/// Follows a session, to tell what is left of it.
#[derive(Debug, Default)]
pub struct OutlookTracker {
    /// When the running attempt began, s.
    began_s: Option<f64>,
    /// Time from the begin of each attempt so far to the next, s, that was neither cut short nor followed by a rest.
    took_s: Vec<f64>,
    shown: Option<tui::event::Outlook>,
}

impl OutlookTracker {
    /// An attempt begins.
    pub fn begin(&mut self, now_s: f64) {
        self.began_s = Some(now_s);
    }

    /// The running attempt is judged.
    pub fn judged(&mut self, now_s: f64) {
        self.took_s
            .extend(self.began_s.take().map(|began_s| now_s - began_s));
    }

    /// The running attempt is over without a verdict.
    pub fn broken_off(&mut self) {
        self.began_s = None;
    }

    /// Returns the outlook if it has become another; its time in steps of 5 s.
    pub fn of(
        &mut self,
        session: &Session,
        progress: Option<&Progress>,
        now_s: f64,
    ) -> Option<tui::event::Outlook> {
        let outlook = self.now(session, progress, now_s);
        if self.shown.as_ref() == Some(&outlook) {
            return None;
        }
        self.shown = Some(outlook.clone());
        Some(outlook)
    }

    fn now(
        &self,
        session: &Session,
        progress: Option<&Progress>,
        now_s: f64,
    ) -> tui::event::Outlook {
        let protocol = session.protocol();
        let left = session.trials_left();
        let number = protocol.planned_trials() - left + 1;
        let trial_s = self.trial_s(session);
        let gone_s = self
            .began_s
            .map_or(0.0, |began_s| (now_s - began_s).min(trial_s));
        let rests = (number + 1..=protocol.planned_trials())
            .filter(|number| rests_before(session, *number))
            .count();
        let left_s = f64::from(left) * trial_s - gone_s + rests as f64 * protocol.rest.min_s;
        let redone = |of_trial: bool| {
            let redone = session.records().iter().filter(|record| {
                matches!(record.outcome, TrialOutcome::Redo { .. })
                    && (!of_trial || record.key.number == number)
            });
            redone.count() as u32
        };
        let in_session = protocol.redo.max_total.saturating_sub(redone(false));
        let (next, then) = steps(session, progress, number);
        tui::event::Outlook {
            left_s: (left_s.max(0.0) / 5.0).round() * 5.0,
            trials_left: left,
            repetitions_of_trial: protocol
                .redo
                .max_per_trial
                .saturating_sub(redone(true))
                .min(in_session),
            repetitions_in_session: in_session,
            next,
            then,
        }
    }

    /// Returns the time of a trial: as the session has gone so far, or as the protocol assumes.
    fn trial_s(&self, session: &Session) -> f64 {
        let timing = &session.protocol().timing;
        if self.took_s.is_empty() {
            return session.protocol().driving_time().trial_s + timing.verdict_s;
        }
        let mean_s = self.took_s.iter().sum::<f64>() / self.took_s.len() as f64;
        mean_s + timing.verdict_s
    }
}

/// Whether a rest comes before trial `number`, counted from 1 with practice.
fn rests_before(session: &Session, number: u32) -> bool {
    let protocol = session.protocol();
    let (every, practice) = (protocol.rest.every_trials, protocol.trials.practice);
    let before = (number - 1).saturating_sub(practice);
    every > 0 && number <= protocol.planned_trials() && before > 0 && before.is_multiple_of(every)
}

/// Returns the next two steps.
fn steps(
    session: &Session,
    progress: Option<&Progress>,
    number: u32,
) -> (Option<String>, Option<String>) {
    let protocol = session.protocol();
    let directions = &protocol.exploration.directions;
    let count = directions.len();
    let at = progress.map_or(0, |progress| progress.exploration.max(1) as usize - 1);
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
    let after = |number: u32| {
        if rests_before(session, number) {
            format!("a rest of {:.0} s", protocol.rest.min_s)
        } else {
            trial(number)
        }
    };
    let is = |words: &str| Some(words.to_owned());
    match session.phase() {
        Phase::Consent => (is("the welcome"), Some(trial(number))),
        Phase::Welcome | Phase::Hold => {
            (is("the plate is driven without a finger"), exploration(0))
        }
        Phase::Baseline => (is("the finger is placed"), exploration(0)),
        Phase::Ready => (is("the countdown"), exploration(at)),
        Phase::Countdown => (exploration(at), is("the finger lifts")),
        Phase::Exploration => (is("the finger lifts"), is("its mean force is shown")),
        Phase::Lift => (
            is("its mean force is shown"),
            exploration(at + 1).or_else(|| is("the verdict")),
        ),
        Phase::Feedback => match exploration(at + 1) {
            Some(next) => (Some(next), None),
            None => (is("the verdict"), Some(after(number + 1))),
        },
        Phase::Analysing => (is("the verdict"), Some(after(number + 1))),
        Phase::Verdict => (Some(after(number + 1)), None),
        Phase::Rest => (Some(trial(number)), None),
        Phase::Paused => (is("p goes on"), Some(trial(number))),
        Phase::Fault => (is("x re-arms"), is("p goes on")),
        Phase::Finished | Phase::Aborted => (None, None),
    }
}
