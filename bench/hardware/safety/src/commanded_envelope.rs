//! Envelope commanded between the frames at which it is known.

use std::collections::VecDeque;

/// Envelope commanded between the rendered frames. Each reading is compared at hundreds of neighbouring frames: the place of
/// one is where the search for the next begins.
pub(crate) struct CommandedEnvelope<'a> {
    commands: &'a VecDeque<(i64, f64)>,
    /// Index of the first command that is not before the last frame asked for.
    next: usize,
}

impl<'a> CommandedEnvelope<'a> {
    pub(crate) fn new(commands: &'a VecDeque<(i64, f64)>) -> Self {
        Self { commands, next: 0 }
    }

    /// Returns the envelope commanded at `frame`, V peak: linear between two known commands, the nearest command
    /// elsewhere.
    pub(crate) fn at(&mut self, frame: i64) -> f64 {
        let is_before = |index: usize| self.commands.get(index).is_some_and(|c| c.0 < frame);
        let mut next = self.next;
        while is_before(next) {
            next += 1;
        }
        while next > 0 && !is_before(next - 1) {
            next -= 1;
        }
        self.next = next;
        let previous = next
            .checked_sub(1)
            .and_then(|index| self.commands.get(index));
        match (previous, self.commands.get(next)) {
            (Some(&(from, low)), Some(&(to, high))) => {
                low + (high - low) * (frame - from) as f64 / (to - from) as f64
            }
            (Some(&(_, volts)), None) | (None, Some(&(_, volts))) => volts,
            (None, None) => 0.0,
        }
    }
}
