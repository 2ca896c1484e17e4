//! Marks of drive stops in a recording, and tones of cues.

use devices::loudspeaker::Tone;
use protocols::{Cue, Interruption};
use recording::manifest::EventKind;
use safety::{SafetyState, Trip};

/// Returns the event of a stop, by its reason.
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

/// Returns the tone of a cue.
pub(super) fn cue_tone(cue: Cue) -> Tone {
    match cue {
        Cue::Start => Tone::Start,
        Cue::End => Tone::End,
    }
}

/// Returns the event of an interruption of a trial.
pub(super) fn interruption_kind(interruption: &Interruption) -> EventKind {
    match interruption {
        Interruption::Paused | Interruption::DisplayLost { .. } => EventKind::Pause,
        Interruption::Redo => EventKind::Redo,
        _ => EventKind::Abort,
    }
}
