//! How a stop of the drive is marked in a recording.

use recording::manifest::EventKind;
use safety::{SafetyState, Trip};

/// The event of a stop, by its reason.
pub(super) fn stop_kind(safety: &SafetyState) -> EventKind {
    match safety {
        SafetyState::Tripped {
            trip: Trip::EmergencyStop | Trip::Operator,
        } => EventKind::EmergencyStop,
        SafetyState::Tripped {
            trip:
                Trip::Readback { .. }
                | Trip::ReadbackMissing
                | Trip::AliveUndriven { .. }
                | Trip::AliveWhileDisarmed { .. },
        } => EventKind::ReadbackMismatch,
        _ => EventKind::Safe,
    }
}
