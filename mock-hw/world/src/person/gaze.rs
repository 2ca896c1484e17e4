//! Perceived positions of the slider, and its present position as predicted by smooth pursuit.

use std::collections::VecDeque;

/// Delay from eye to hand in smooth pursuit, s.
const VISUAL_DELAY_S: f64 = 0.1;
/// Time over which the speed is estimated, s.
const SPEED_WINDOW_S: f64 = 0.1;
/// Time after which a perceived position is forgotten, s.
const MEMORY_S: f64 = 1.0;
/// Least time between two perceived positions, s.
const GLANCE_S: f64 = 5e-3;
const GLANCES: usize = 256;
/// Fraction of the visual delay that prediction compensates.
const PREDICTION: f64 = 0.8;

/// Perceived positions of the slider.
#[derive(Debug, Clone)]
pub(crate) struct Gaze {
    glances: VecDeque<(f64, f64)>,
}

/// Position, m, and velocity, m/s, for the hand to follow.
pub(crate) type Pursuit = Option<(f64, f64)>;

impl Gaze {
    pub fn new() -> Self {
        Self {
            glances: VecDeque::with_capacity(GLANCES),
        }
    }

    /// Records the slider's position at `t_s`; a hidden slider clears all positions.
    pub fn see(&mut self, t_s: f64, slider_m: Option<f64>) {
        let Some(position_m) = slider_m else {
            self.glances.clear();
            return;
        };
        if self
            .glances
            .back()
            .is_some_and(|(glance_s, _)| t_s < glance_s + GLANCE_S)
        {
            return;
        }
        while self
            .glances
            .front()
            .is_some_and(|(glance_s, _)| *glance_s < t_s - MEMORY_S)
        {
            self.glances.pop_front();
        }
        self.glances.push_back((t_s, position_m));
    }

    /// Returns the latest perceived position, m, for a mark at rest.
    pub fn latest(&self) -> Option<f64> {
        self.glances.back().map(|(_, position_m)| *position_m)
    }

    /// Returns the slider's position and velocity as pursued at `t_s`.
    pub fn pursuit(&self, t_s: f64) -> Pursuit {
        let now_s = t_s - VISUAL_DELAY_S;
        let position_m = self.position_at(now_s)?;
        let before_s = (now_s - SPEED_WINDOW_S).max(self.glances.front()?.0);
        let span_s = now_s - before_s;
        let velocity = if span_s > 0.02 {
            (position_m - self.position_at(before_s)?) / span_s
        } else {
            0.0
        };
        Some((
            position_m + PREDICTION * VISUAL_DELAY_S * velocity,
            velocity,
        ))
    }

    /// Returns the perceived position at `t_s`, interpolated, m.
    fn position_at(&self, t_s: f64) -> Option<f64> {
        let index = self
            .glances
            .partition_point(|(glance_s, _)| *glance_s <= t_s);
        let (from_s, from_m) = *self.glances.get(index.checked_sub(1)?)?;
        Some(match self.glances.get(index) {
            Some(&(to_s, to_m)) => from_m + (t_s - from_s) / (to_s - from_s) * (to_m - from_m),
            None => from_m,
        })
    }
}
