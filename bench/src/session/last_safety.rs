//! The safety watch as the session last saw it.

use protocols::SafetyChain;
use safety::SafetyState;

/// State of the safety watch at the session's last look.
#[derive(Default)]
pub(super) struct LastSafety {
    /// The state.
    pub(super) state: SafetyState,
    /// Whether a trip requested by the session is still to come.
    pub(super) is_tripping: bool,
}

impl LastSafety {
    /// Takes the present state; returns the previous one if it differs.
    pub(super) fn renew(&mut self, state: SafetyState) -> Option<SafetyState> {
        self.is_tripping &= !matches!(state, SafetyState::Tripped { .. });
        (state != self.state).then(|| std::mem::replace(&mut self.state, state))
    }

    /// Returns the state as the protocol's state machine observes it.
    pub(super) fn observed(&self) -> SafetyChain {
        match &self.state {
            SafetyState::Tripped { trip } => SafetyChain::Tripped(trip.to_string()),
            SafetyState::Armed | SafetyState::Disarmed => SafetyChain::Ok,
        }
    }
}
