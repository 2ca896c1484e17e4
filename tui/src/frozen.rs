//! Frozen strips.

use std::collections::VecDeque;

use crate::event::Live;

/// Live values at the time when the operator froze the strips, with two cursors.
#[derive(Clone, Debug, PartialEq)]
pub struct Frozen {
    /// Live values, oldest first.
    pub history: VecDeque<Live>,
    /// The cursors, from 0 at the left end of the strips to 1 at the right.
    pub cursors: [f64; 2],
}

/// Step of a cursor per key press.
const STEP: f64 = 0.01;

impl Frozen {
    /// Freezes `history`, which must have at least one value.
    #[must_use]
    pub fn new(history: VecDeque<Live>) -> Self {
        Self {
            history,
            cursors: [0.25, 0.75],
        }
    }

    /// Moves a cursor by a number of steps.
    pub fn step(&mut self, cursor: usize, steps: f64) {
        if let Some(position) = self.cursors.get_mut(cursor) {
            *position = (*position + steps * STEP).clamp(0.0, 1.0);
        }
    }

    /// Returns the times of the cursors on strips that span `window_s`, s.
    #[must_use]
    pub fn times_s(&self, window_s: f64) -> [f64; 2] {
        let last_s = self.history.back().map_or(0.0, |live| live.t_s);
        self.cursors
            .map(|position| last_s - (1.0 - position) * window_s)
    }

    /// Returns the value nearest to `t_s`.
    #[must_use]
    pub fn value_at(&self, t_s: f64) -> Option<&Live> {
        let index = self.history.partition_point(|live| live.t_s < t_s);
        self.history
            .get(index.min(self.history.len().checked_sub(1)?))
    }
}
