//! How a stop of the drive is marked in a recording.

use protocols::Interruption;
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

/// Returns the event of what interrupts a trial.
pub(super) fn interruption_kind(interruption: &Interruption) -> EventKind {
    match interruption {
        Interruption::Paused => EventKind::Pause,
        Interruption::Redo => EventKind::Redo,
        _ => EventKind::Abort,
    }
}
