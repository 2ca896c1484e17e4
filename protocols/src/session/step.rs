//! One step of a session: observe, obey safety and operator, advance, show.

use super::action::{SessionAction, StepActions};
use super::event::{SessionEventKind, SessionOutcome};
use super::machine::Session;
use super::observation::{Observation, OperatorCommand, RecordingOutcome};
use super::phase::Phase;
use super::plan::PlannedTrial;
use super::state::State;
use crate::rules::is_touching;

impl Session {
    /// Takes an observation and returns the actions for the bench, in order.
    pub fn step(&mut self, observation: &Observation) -> Vec<SessionAction> {
        let mut out = StepActions::at(self.observe(observation));
        let phase = self.phase();
        if !self.has_started {
            self.has_started = true;
            out.log(self.start_event());
            out.log(SessionEventKind::Phase { phase });
        }
        let is_halted = self.safety(observation, &mut out)
            | self.display(observation, &mut out)
            | self.recording_failed(&mut out);
        let is_commanded = self.command(observation, &mut out);
        if !is_halted && !is_commanded {
            self.advance(observation, &mut out);
        }
        if self.phase() != phase {
            out.log(SessionEventKind::Phase {
                phase: self.phase(),
            });
        }
        if let State::Finished { aborted } = self.state
            && !matches!(phase, Phase::Finished | Phase::Aborted)
        {
            self.finish(aborted, &mut out);
        }
        out.push(SessionAction::Show(self.view()));
        out.actions
    }

    /// Stores time, finger, analysis and the recording's outcome; returns the time of the step, s.
    pub(super) fn observe(&mut self, observation: &Observation) -> f64 {
        if observation.t_s.is_finite() && observation.t_s > self.now_s {
            self.now_s = observation.t_s;
        }
        self.hold = observation.hold;
        self.drive_wait_s = observation.drive_wait_s;
        self.is_attended = observation.attended;
        self.is_asking = observation.asking;
        let contact_n = self.protocol.force.contact_n;
        self.finger = is_touching(self.finger, observation.normal_n, contact_n);
        if let Some(analysis) = &observation.analysis
            && self.analysis_key.as_ref() == Some(&analysis.key)
        {
            self.analysis_key = None;
            self.analysis = Some(analysis.clone());
        }
        self.recorder_lag_s = observation.recorder_lag_s;
        if let Some((key, outcome)) = &observation.recording
            && self.current() == Some(key)
            // A failed recording stays failed; later reports do not change that.
            && !matches!(self.recording_outcome, Some(RecordingOutcome::Failed(_)))
        {
            self.recording_outcome = Some(outcome.clone());
        }
        self.now_s
    }

    /// Advances the state by time, finger and button.
    fn advance(&mut self, observation: &Observation, out: &mut StepActions) {
        let is_continued = observation.command == Some(OperatorCommand::Continue);
        let go_on = is_continued || observation.button_pressed;
        self.state = match self.take_state() {
            State::Welcome if go_on => self.next_trial(out),
            State::Hold { since_s } => self.advance_hold(since_s, out),
            State::Trial {
                open,
                step,
                since_s,
            } => self.advance_trial(open, step, since_s, go_on, observation.normal_n, out),
            State::Analysing { key, since_s } => self.advance_analysis(key, since_s, out),
            State::Judged {
                key,
                analysis,
                reasons,
                since_s,
            } if !observation.asking
                && (is_continued || self.elapsed_s(since_s) >= self.verdict_s(&reasons)) =>
            {
                let outcome = self.outcome(&key, reasons);
                self.settle(key, analysis, outcome, out)
            }
            State::Saving {
                key,
                analysis,
                outcome,
                since_s,
            } => self.advance_saving(key, analysis, outcome, since_s, out),
            State::Behind {
                since_s,
                is_reported,
            } => self.advance_behind(since_s, is_reported, out),
            State::Rest { since_s }
                if is_continued || (go_on && self.rest_left_s(since_s) <= 0.0) =>
            {
                self.next_trial(out)
            }
            state => state,
        };
    }

    pub(super) fn finish(&self, aborted: bool, out: &mut StepActions) {
        let summary = self.summary();
        let outcome = if aborted {
            SessionOutcome::Aborted { summary }
        } else {
            SessionOutcome::Completed { summary }
        };
        out.log(SessionEventKind::SessionEnded {
            outcome: outcome.clone(),
        });
        out.push(SessionAction::Finished(outcome));
    }

    fn start_event(&self) -> SessionEventKind {
        let name = |trial: &PlannedTrial| trial.condition.name.clone();
        SessionEventKind::SessionStarted {
            participant: self.participant.clone(),
            protocol: self.protocol.name.clone(),
            seed: self.seed,
            order: self.attempts.plan().iter().map(name).collect(),
            resumed_attempts: self.resumed_attempts,
        }
    }
}
