//! State of the safety watch as an event for screens.

use safety::{DoseLeft, SafetyState};

/// Returns the watch's state as an event, with the `left` driving time of the hour unless the watch tripped; `driving` tells a
/// bench that drives the plate from one that is armed and silent.
#[must_use]
pub fn safety_event(state: &SafetyState, driving: bool, left: Option<&DoseLeft>) -> tui::Event {
    let left = left.map(DoseLeft::in_words);
    let (state, reason) = match state {
        SafetyState::Disarmed => (tui::event::SafetyView::Disarmed, left),
        SafetyState::Armed if driving => (tui::event::SafetyView::Driving, left),
        SafetyState::Armed => (tui::event::SafetyView::Armed, left),
        SafetyState::Tripped { trip } => (tui::event::SafetyView::Tripped, Some(trip.to_string())),
    };
    tui::Event::Safety { state, reason }
}
