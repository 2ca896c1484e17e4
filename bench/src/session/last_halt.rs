//! The last pause or fault of a session, until a trial follows it.
//!
//! | state | event | next state |
//! | --- | --- | --- |
//! | any | the session pauses automatically | `Paused` |
//! | any | the session leaves a pause or a fault | `Over` |
//! | `NoHalt` | a resumed session starts | `Over` |
//! | `Over` | a trial begins | `NoHalt` |

use protocols::Phase;

/// Last halt of a session.
#[derive(Default)]
pub(super) enum LastHalt {
    /// No halt since the last trial began, or a halt without a reason of its own.
    #[default]
    NoHalt,
    /// Automatic pause, with its reason.
    Paused(String),
    /// The halt is over: the next trial follows this event, not another trial.
    Over(&'static str),
}

impl LastHalt {
    /// Takes a step of the session between two phases.
    pub(super) fn step(&mut self, before: Phase, after: Phase) {
        let is_halted = |phase| matches!(phase, Phase::Paused | Phase::Fault);
        if is_halted(before) && !is_halted(after) {
            *self = Self::Over(match before {
                Phase::Fault => "after a fault",
                _ => "after a pause",
            });
        }
    }

    /// Returns the event that a beginning trial follows, if it does not follow another trial.
    pub(super) fn take_event(&mut self) -> Option<&'static str> {
        let Self::Over(event) = *self else {
            return None;
        };
        *self = Self::NoHalt;
        Some(event)
    }

    /// Returns the reason for the last automatic pause.
    pub(super) fn pause(&self) -> Option<&str> {
        match self {
            Self::Paused(reason) => Some(reason),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_follows_the_last_halt_once() {
        for (phase, event) in [
            (Phase::Paused, "after a pause"),
            (Phase::Fault, "after a fault"),
        ] {
            let mut halt = LastHalt::Paused("why".to_owned());
            halt.step(phase, phase);
            halt.step(Phase::Paused, Phase::Fault);
            assert_eq!(halt.take_event(), None);
            assert_eq!(halt.pause(), Some("why"));
            halt.step(phase, Phase::Baseline);
            assert_eq!(halt.pause(), None);
            assert_eq!(halt.take_event(), Some(event));
            assert_eq!(halt.take_event(), None);
        }
    }
}
