//! Percepts passed from the bench's screen to the simulated person.

use std::sync::{Arc, Mutex, PoisonError};

use mock_world::person::Percept;

/// Handle that shows percepts to the simulated person; any thread may hold a clone.
#[derive(Debug, Clone, Default)]
pub struct Senses(Arc<Mutex<Percept>>);

impl Senses {
    /// Shows a percept, which the person acts on from the next period until another is shown.
    ///
    /// A cue sounds once, and is heard even if another percept follows within the same period.
    pub fn show(&self, percept: Percept) {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let previous_cue = latest.cue;
        *latest = percept;
        latest.cue = percept.cue.or(previous_cue);
    }

    /// Returns the percept for the period that begins.
    pub(super) fn perceive(&self) -> Percept {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let percept = *latest;
        latest.cue = None;
        percept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mock_world::person::HeardCue;

    #[test]
    fn a_cue_is_heard_once_and_never_overwritten_by_silence() {
        let senses = Senses::default();
        senses.show(Percept {
            cue: Some(HeardCue::Start),
            ..Percept::default()
        });
        senses.show(Percept {
            countdown: Some(2),
            ..Percept::default()
        });
        let first = senses.perceive();
        assert_eq!(
            (first.cue, first.countdown),
            (Some(HeardCue::Start), Some(2))
        );
        let second = senses.perceive();
        assert_eq!((second.cue, second.countdown), (None, Some(2)));
    }
}
