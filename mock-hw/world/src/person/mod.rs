//! Virtual participant: perceives the screen and cue sounds, moves one finger and presses a button.

mod gaze;
mod hand;
mod percept;
mod pressing;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use gaze::Gaze;
use hand::Hand;
pub use percept::{Act, FingerState, HeardCue, PerceivedInstruction, Percept};
use pressing::Pressing;

use crate::scenario::{BehaviourTable, ParticipantTable};
use crate::seed;

/// Longest step of the integration of motion and force, s.
const LONGEST_STEP_S: f64 = 1e-3;
/// Position of the idle hand before the first start mark, m.
const IDLE_POSITION_M: f64 = 0.0;
/// Time from readiness to the button press, s.
const SETTLE_S: f64 = 0.5;
/// Earliest time of an erroneous lift, s after the start of the exploration.
const LIFT_FROM_S: f64 = 0.4;
/// Length of the time window in which an erroneous lift begins, s.
const LIFT_WITHIN_S: f64 = 0.8;
/// Time for which the button is held down, s.
const BUTTON_HOLD_S: f64 = 0.15;
/// Time without a response after which the button is pressed again, s.
const IMPATIENCE_S: f64 = 2.0;

/// One simulated participant.
///
/// ```
/// use mock_world::person::{PerceivedInstruction, Percept, VirtualPerson};
/// use mock_world::scenario::Scenario;
///
/// let mut person = VirtualPerson::draw(&Scenario::default().participant, 1);
/// let percept = Percept {
///     instruction: PerceivedInstruction::PlaceFinger,
///     slider_m: Some(0.01),
///     ..Percept::default()
/// };
/// let acts: Vec<_> = (0..400)
///     .map(|n| person.step(0.01 * f64::from(n), 0.01, &percept))
///     .collect();
/// assert!(!acts[0].finger.touching);
/// assert!(acts[399].finger.touching);
/// assert!(acts.iter().any(|act| act.button_pressed));
/// ```
#[derive(Debug, Clone)]
pub struct VirtualPerson {
    behaviour: BehaviourTable,
    rng: ChaCha8Rng,
    gaze: Gaze,
    hand: Hand,
    press: Pressing,
    /// Instruction being followed.
    instruction: PerceivedInstruction,
    /// Instruction perceived but not yet reacted to, and the time of the reaction, s.
    reaction: Option<(PerceivedInstruction, f64)>,
    settled_since_s: Option<f64>,
    button_until_s: f64,
    lift_at_s: Option<f64>,
    learnt_from_feedback: bool,
    /// Whether the end cue was heard; a slider still shown is then ignored.
    heard_end: bool,
}

impl VirtualPerson {
    /// Draws the person of `seed`.
    #[must_use]
    pub fn draw(participant: &ParticipantTable, seed: u64) -> Self {
        let behaviour = participant.behaviour.clone();
        let mut rng = seed::stream(seed, seed::RandomStream::Person);
        let mut score = || -> f64 { StandardNormal.sample(&mut rng) };
        let press = Pressing::new(&behaviour, score());
        let hand = Hand::new(&behaviour, IDLE_POSITION_M, score());
        Self {
            behaviour,
            rng,
            gaze: Gaze::new(),
            hand,
            press,
            instruction: PerceivedInstruction::Wait,
            reaction: None,
            settled_since_s: None,
            button_until_s: f64::NEG_INFINITY,
            lift_at_s: None,
            learnt_from_feedback: false,
            heard_end: false,
        }
    }

    /// Shows `percept` at `t_s`; returns the person's act at `t_s + dt_s`.
    pub fn step(&mut self, t_s: f64, dt_s: f64, percept: &Percept) -> Act {
        self.gaze.see(t_s, percept.slider_m);
        self.notice(t_s, percept);
        let steps = (dt_s / LONGEST_STEP_S).ceil().max(1.0);
        let h_s = dt_s / steps;
        for i in 0..steps as usize {
            self.advance(t_s + i as f64 * h_s, h_s);
        }
        self.act(t_s + dt_s)
    }

    /// Perceives a percept and schedules the reaction to a new instruction.
    fn notice(&mut self, t_s: f64, percept: &Percept) {
        // The end cue is perceived before the screen.
        let is_following = percept.instruction == PerceivedInstruction::FollowSlider;
        self.heard_end = is_following && (self.heard_end || percept.cue == Some(HeardCue::End));
        let instruction = if self.heard_end {
            PerceivedInstruction::LiftFinger
        } else {
            percept.instruction
        };
        if let Some((low, high)) = percept.force_band_n {
            self.press.aim_at(0.5 * (low + high));
        }
        if let (PerceivedInstruction::Feedback, Some(mean_n)) = (instruction, percept.mean_force_n)
            && !self.learnt_from_feedback
        {
            self.press.learn(mean_n);
            self.learnt_from_feedback = true;
        }
        let latest = self
            .reaction
            .map_or(self.instruction, |(instruction, _)| instruction);
        if instruction == latest {
            return;
        }
        if instruction == PerceivedInstruction::FollowSlider {
            self.learnt_from_feedback = false;
        }
        let at_s = t_s + self.reaction_s(instruction);
        self.reaction = Some((instruction, at_s));
    }

    /// Draws the reaction time to an instruction, s.
    fn reaction_s(&mut self, to: PerceivedInstruction) -> f64 {
        let white: f64 = StandardNormal.sample(&mut self.rng);
        let reaction_s = self.behaviour.reaction_s * (0.2 * white).exp();
        let is_late = to == PerceivedInstruction::FollowSlider
            && self.rng.random::<f64>() < self.behaviour.late_start_probability;
        reaction_s
            + if is_late {
                self.behaviour.late_start_s
            } else {
                0.0
            }
    }

    /// Begins to follow an instruction.
    fn begin(&mut self, instruction: PerceivedInstruction, t_s: f64) {
        self.instruction = instruction;
        self.settled_since_s = None;
        self.lift_at_s = None;
        if instruction == PerceivedInstruction::FollowSlider {
            let chance: f64 = self.rng.random();
            let share: f64 = self.rng.random();
            if chance < self.behaviour.lift_off_probability {
                self.lift_at_s = Some(t_s + LIFT_FROM_S + LIFT_WITHIN_S * share);
            }
        }
    }

    /// Integrates motion and force over `h_s`.
    fn advance(&mut self, t_s: f64, h_s: f64) {
        if let Some((instruction, at_s)) = self.reaction
            && t_s >= at_s
        {
            self.reaction = None;
            self.begin(instruction, t_s);
        }
        match self.instruction {
            PerceivedInstruction::Wait if self.behaviour.rests_unasked => {
                self.press.press();
                self.hand.rest(h_s, &mut self.rng);
            }
            PerceivedInstruction::Wait
            | PerceivedInstruction::LiftFinger
            | PerceivedInstruction::Feedback
            | PerceivedInstruction::Rest
            | PerceivedInstruction::Paused
            | PerceivedInstruction::Finished => {
                self.press.lift();
                self.hand.rest(h_s, &mut self.rng);
            }
            PerceivedInstruction::PressButton => {
                self.press.lift();
                self.hand.rest(h_s, &mut self.rng);
                self.press_button_once_settled(t_s);
            }
            PerceivedInstruction::PlaceFinger => self.place(t_s, h_s),
            PerceivedInstruction::GetReady => {
                self.press.press();
                self.hand.rest(h_s, &mut self.rng);
            }
            PerceivedInstruction::FollowSlider => {
                let is_lifted = self
                    .lift_at_s
                    .is_some_and(|at_s| (at_s..at_s + self.behaviour.lift_off_s).contains(&t_s));
                if is_lifted {
                    self.press.lift();
                } else {
                    self.press.press();
                }
                let pursuit = self.gaze.pursuit(t_s);
                self.hand.pursue(pursuit, h_s, &mut self.rng);
            }
        }
        self.press.advance(h_s, &mut self.rng);
    }

    /// Moves to the mark with the finger lifted, then lands, settles and presses the button.
    fn place(&mut self, t_s: f64, h_s: f64) {
        let Some(mark_m) = self.gaze.latest() else {
            self.hand.rest(h_s, &mut self.rng);
            return;
        };
        let has_arrived = self
            .hand
            .reach(mark_m, self.press.is_touching(), h_s, &mut self.rng);
        if !has_arrived {
            if !self.press.is_touching() {
                self.press.lift();
            }
            return;
        }
        self.press.press();
        self.press_button_once_settled(t_s);
    }

    /// Presses the button after a delay, and again if there is no response.
    fn press_button_once_settled(&mut self, t_s: f64) {
        let since_s = *self.settled_since_s.get_or_insert(t_s);
        if t_s - since_s >= SETTLE_S {
            self.button_until_s = t_s + BUTTON_HOLD_S;
            self.settled_since_s = Some(t_s + IMPATIENCE_S - SETTLE_S);
        }
    }

    /// Returns the person's act at `t_s`.
    fn act(&self, t_s: f64) -> Act {
        let normal_n = self.press.force_n();
        let (position_m, velocity_m_per_s) = self.hand.motion();
        Act {
            finger: FingerState {
                position_m,
                velocity_m_per_s,
                normal_n,
                touching: normal_n > 0.0,
            },
            button_pressed: t_s < self.button_until_s,
        }
    }
}
