//! Screen of a trial, from the start of the drive to its end.

use super::course::{
    BAND_N, BASELINE_S, COUNTDOWN_S, FEEDBACK_S, LIFTED_S, PATIENCE_S, PLACING_S, REST_OF_STROKE_S,
    SETTLE_S, SPEED_M_PER_S, TRAVEL_M, TRAVEL_S, UNLOADED_S,
};
use super::plan::TrialPlan;
use super::readings::Stroke;
use crate::person::{Act, HeardCue, PerceivedInstruction, Percept};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Unloaded,
    Placing,
    Countdown,
    Sliding,
    Feedback,
    /// Unloaded plate until the end.
    Tail,
}

/// Screen of a trial, with the intervals so far.
#[derive(Debug, Clone)]
pub(super) struct Script {
    strokes_left: u32,
    duration_s: Option<f64>,
    stage: Stage,
    since_s: f64,
    /// Whether the participant has pressed the button in this stage.
    pressed: bool,
    last_touch_s: f64,
    /// Sum and number of the normal forces of this stroke.
    force: (f64, u32),
    mean_force_n: f64,
    strokes: Vec<Stroke>,
}

impl Script {
    pub(super) fn new(plan: &TrialPlan) -> Self {
        Self {
            strokes_left: plan.strokes,
            duration_s: plan.duration_s,
            stage: Stage::Unloaded,
            since_s: 0.0,
            pressed: false,
            last_touch_s: 0.0,
            force: (0.0, 0),
            mean_force_n: 0.0,
            strokes: Vec::new(),
        }
    }

    /// Returns the screen at `t_s`; `None` after the end.
    pub(super) fn percept(&mut self, t_s: f64) -> Option<Percept> {
        let end_s = self.duration_s.unwrap_or(match self.stage {
            Stage::Tail => self.since_s.max(self.last_touch_s + LIFTED_S) + BASELINE_S,
            _ => f64::INFINITY,
        });
        if t_s >= end_s {
            return None;
        }
        let mut cue = None;
        while let Some(next) = self.next(t_s) {
            cue = match (self.stage, next) {
                (_, Stage::Sliding) => Some(HeardCue::Start),
                (Stage::Sliding, _) => Some(HeardCue::End),
                _ => None,
            };
            self.enter(next, t_s);
        }
        let [left_m, right_m] = TRAVEL_M;
        let travelled_m = match self.stage {
            Stage::Sliding => SPEED_M_PER_S * (t_s - self.since_s),
            _ => 0.0,
        };
        let slider_m = if self.is_rightwards() {
            left_m + travelled_m
        } else {
            right_m - travelled_m
        };
        let instruction = match self.stage {
            Stage::Unloaded | Stage::Tail => PerceivedInstruction::LiftFinger,
            Stage::Placing => PerceivedInstruction::PlaceFinger,
            Stage::Countdown => PerceivedInstruction::GetReady,
            Stage::Sliding => PerceivedInstruction::FollowSlider,
            Stage::Feedback => PerceivedInstruction::Feedback,
        };
        let is_marked = matches!(
            self.stage,
            Stage::Placing | Stage::Countdown | Stage::Sliding
        );
        Some(Percept {
            instruction,
            slider_m: is_marked.then_some(slider_m),
            countdown: None,
            mean_force_n: (self.stage == Stage::Feedback).then_some(self.mean_force_n),
            force_band_n: Some(BAND_N),
            cue,
        })
    }

    /// Takes the person's act at `t_s`.
    pub(super) fn watch(&mut self, t_s: f64, act: &Act) {
        self.pressed |= act.button_pressed;
        if act.finger.touching {
            self.last_touch_s = t_s;
        }
        if self.stage == Stage::Sliding {
            self.force.0 += act.finger.normal_n;
            self.force.1 += 1;
        }
    }

    /// Returns the unloaded stretches, s, and the strokes of a trial that ended at `end_s`.
    pub(super) fn finish(self, end_s: f64) -> (Vec<(f64, f64)>, Vec<Stroke>) {
        let mut unloaded_s = vec![(SETTLE_S, UNLOADED_S)];
        let tail_s = self.since_s.max(self.last_touch_s + LIFTED_S);
        if self.stage == Stage::Tail && end_s - tail_s > 0.5 * BASELINE_S {
            unloaded_s.push((tail_s, end_s));
        }
        (unloaded_s, self.strokes)
    }

    /// Returns the stage that begins at `t_s`, if any does.
    fn next(&self, t_s: f64) -> Option<Stage> {
        let elapsed_s = t_s - self.since_s;
        let has_time = |needed_s: f64| {
            self.duration_s
                .is_none_or(|duration_s| t_s + needed_s <= duration_s)
        };
        let upcoming = || {
            if self.strokes_left > 0 && has_time(PLACING_S + COUNTDOWN_S + REST_OF_STROKE_S) {
                Stage::Placing
            } else {
                Stage::Tail
            }
        };
        match self.stage {
            Stage::Unloaded => (elapsed_s >= UNLOADED_S).then(upcoming),
            Stage::Placing if self.pressed => Some(Stage::Countdown),
            Stage::Placing => (elapsed_s >= PATIENCE_S).then_some(Stage::Tail),
            Stage::Countdown if elapsed_s < COUNTDOWN_S => None,
            Stage::Countdown if has_time(REST_OF_STROKE_S) => Some(Stage::Sliding),
            Stage::Countdown => Some(Stage::Tail),
            Stage::Sliding if elapsed_s < TRAVEL_S => None,
            Stage::Sliding if self.strokes_left > 1 => Some(Stage::Feedback),
            Stage::Sliding => Some(Stage::Tail),
            Stage::Feedback => (elapsed_s >= FEEDBACK_S).then(upcoming),
            Stage::Tail => None,
        }
    }

    /// Returns whether the present stroke, or the next one, goes towards increasing position.
    fn is_rightwards(&self) -> bool {
        self.strokes.len().is_multiple_of(2)
    }

    fn enter(&mut self, next: Stage, t_s: f64) {
        if self.stage == Stage::Sliding {
            self.strokes.push(Stroke {
                start_s: self.since_s,
                end_s: t_s,
                rightwards: self.is_rightwards(),
            });
            self.strokes_left -= 1;
            let (sum_n, count) = std::mem::take(&mut self.force);
            self.mean_force_n = sum_n / f64::from(count.max(1));
        }
        (self.stage, self.since_s, self.pressed) = (next, t_s, false);
    }
}
