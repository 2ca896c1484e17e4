//! State of the safety watch as an event for screens.

use safety::SafetyState;

/// Returns the watch's state as an event; `driving` tells an armed bench that drives the plate from a silent one.
#[must_use]
pub fn safety_event(state: &SafetyState, driving: bool) -> tui::Event {
    let (state, reason) = match state {
        SafetyState::Disarmed => (tui::event::SafetyState::Disarmed, None),
        SafetyState::Armed if driving => (tui::event::SafetyState::Driving, None),
        SafetyState::Armed => (tui::event::SafetyState::Armed, None),
        SafetyState::Tripped { trip } => (tui::event::SafetyState::Tripped, Some(trip.to_string())),
    };
    tui::Event::Safety { state, reason }
}
