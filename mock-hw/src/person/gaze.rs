//! What the eyes have seen of the slider: its past, and the guess of its present that smooth pursuit makes.

use std::collections::VecDeque;

/// From the eye to the hand in smooth pursuit, s.
const VISUAL_DELAY_S: f64 = 0.1;
/// The eyes judge speed over this long, s.
const SPEED_WINDOW_S: f64 = 0.1;
/// How far back anything is remembered, s.
const MEMORY_S: f64 = 1.0;
/// The eyes are sampled no oftener than this, s.
const GLANCE_S: f64 = 5e-3;
const GLANCES: usize = 256;
/// Share of the visual delay that prediction makes up for.
const PREDICTION: f64 = 0.8;

/// The seen past of the slider.
#[derive(Debug, Clone)]
pub(crate) struct Gaze {
    seen: VecDeque<(f64, f64)>,
}

/// What the hand is to follow: position, m, and velocity, m/s.
pub(crate) type Pursued = Option<(f64, f64)>;

impl Gaze {
    pub fn new() -> Self {
        Self {
            seen: VecDeque::with_capacity(GLANCES),
        }
    }

    pub fn see(&mut self, t_s: f64, slider_m: Option<f64>) {
        let Some(position_m) = slider_m else {
            self.seen.clear();
            return;
        };
        if self
            .seen
            .back()
            .is_some_and(|(then_s, _)| t_s < then_s + GLANCE_S)
        {
            return;
        }
        while self
            .seen
            .front()
            .is_some_and(|(then_s, _)| *then_s < t_s - MEMORY_S)
        {
            self.seen.pop_front();
        }
        self.seen.push_back((t_s, position_m));
    }

    /// The slider where it is now (for a mark that stands still).
    pub fn latest(&self) -> Option<f64> {
        self.seen.back().map(|(_, position_m)| *position_m)
    }

    /// The slider as it is pursued at `t_s`.
    pub fn pursued(&self, t_s: f64) -> Pursued {
        let now_s = t_s - VISUAL_DELAY_S;
        let position_m = self.at(now_s)?;
        let before_s = (now_s - SPEED_WINDOW_S).max(self.seen.front()?.0);
        let span_s = now_s - before_s;
        let velocity = if span_s > 0.02 {
            (position_m - self.at(before_s)?) / span_s
        } else {
            0.0
        };
        Some((
            position_m + PREDICTION * VISUAL_DELAY_S * velocity,
            velocity,
        ))
    }

    fn at(&self, t_s: f64) -> Option<f64> {
        let after = self.seen.partition_point(|(then_s, _)| *then_s <= t_s);
        let (from_s, from_m) = *self.seen.get(after.checked_sub(1)?)?;
        Some(match self.seen.get(after) {
            Some(&(to_s, to_m)) => from_m + (t_s - from_s) / (to_s - from_s) * (to_m - from_m),
            None => from_m,
        })
    }
}
