//! The participant's view in each state.

use super::machine::Session;
use super::observation::DeadManAction;
use super::participant_view::{ParticipantView, Progress, repeat_cause};
use super::state::{OpenTrial, State, TrialStep};
use crate::record::TrialOutcome;
use crate::trial::TrialKey;
use participant_texts::Instruction;

impl Session {
    /// Returns the participant's view of the present state.
    pub(super) fn view(&self) -> ParticipantView {
        let mut view = ParticipantView {
            instruction: Instruction::Wait,
            slider_m: None,
            direction: None,
            countdown_s: None,
            mean_force_n: None,
            force_band: self.protocol.force,
            button: false,
            progress: None,
            repeat: None,
        };
        match &self.state {
            State::Consent => {}
            State::Behind { .. } => {}
            State::Analysing { key, .. } | State::Saving { key, .. } => {
                view.progress = Some(self.progress(key, None))
            }
            State::Judged { key, reasons, .. } => {
                view.progress = Some(self.progress(key, None));
                let outcome = self.outcome(key, reasons.clone());
                if matches!(outcome, TrialOutcome::Redo { .. }) {
                    view.repeat = Some(repeat_cause(reasons));
                }
            }
            State::Welcome => {
                view.instruction = Instruction::Welcome;
                view.button = true;
            }
            State::Hold { .. } => {
                view.instruction = match self.hold {
                    Some(DeadManAction::Release) => Instruction::ReleaseSwitch,
                    Some(DeadManAction::Press) => Instruction::HoldSwitch,
                    Some(DeadManAction::Held) | None => Instruction::Wait,
                }
            }
            State::Trial {
                open,
                step,
                since_s,
            } => self.view_trial(open, step, *since_s, &mut view),
            State::Rest { since_s } => {
                let left_s = self.rest_left_s(*since_s);
                view.instruction = Instruction::Rest;
                view.countdown_s = Some(left_s);
                view.button = left_s <= 0.0;
            }
            State::Halted { fault: true, .. } if self.let_go => {
                view.instruction = Instruction::SwitchReleased;
            }
            State::Halted { .. } => view.instruction = Instruction::Paused,
            State::Finished { .. } => view.instruction = Instruction::Finished,
        }
        view
    }

    fn view_trial(
        &self,
        open: &OpenTrial,
        step: &TrialStep,
        since_s: f64,
        view: &mut ParticipantView,
    ) {
        let elapsed_s = self.elapsed_s(since_s);
        let (instruction, exploration) = match step {
            TrialStep::Baseline { .. } if self.finger == Some(false) => (Instruction::Wait, None),
            TrialStep::Baseline { .. } => (Instruction::LiftFinger, None),
            TrialStep::Ready { exploration } => {
                view.button = self.finger == Some(true);
                view.slider_m = Some(self.slider(*exploration).from_m);
                (Instruction::PlaceFinger, Some(*exploration))
            }
            TrialStep::Countdown { exploration } => {
                view.slider_m = Some(self.slider(*exploration).from_m);
                view.countdown_s = Some(self.protocol.timing.countdown_s - elapsed_s);
                (Instruction::GetReady, Some(*exploration))
            }
            TrialStep::Exploration { exploration, .. } => {
                view.slider_m = Some(self.slider(*exploration).position_m(elapsed_s));
                (Instruction::FollowSlider, Some(*exploration))
            }
            TrialStep::Lift { exploration, .. } => (Instruction::LiftFinger, Some(*exploration)),
            TrialStep::Feedback {
                exploration,
                mean_n,
            } => {
                view.mean_force_n = *mean_n;
                (Instruction::Feedback, Some(*exploration))
            }
        };
        view.instruction = instruction;
        view.direction = view.slider_m.and(exploration).map(|e| self.direction(e));
        view.progress = Some(self.progress(&open.key, exploration));
    }

    fn progress(&self, key: &TrialKey, exploration: Option<usize>) -> Progress {
        Progress {
            trial: key.number,
            trials: self.attempts.plan().len() as u32,
            exploration: exploration.map_or(0, |e| e as u32 + 1),
            explorations: self.protocol.exploration.directions.len() as u32,
            practice: key.practice,
            attempt: key.attempt,
        }
    }
}
