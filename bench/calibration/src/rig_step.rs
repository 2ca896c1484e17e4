//! What the bench under calibration is doing.

use signalgen::Waveform;

use crate::operator::Answer;
use crate::procedure::NextStep;

/// The step that is under way.
pub(super) enum Step {
    Settling,
    /// The tone before is ramping to silence.
    SilencingTone {
        next: Option<NextStep>,
        quiet_frames: usize,
    },
    Listening {
        until: usize,
    },
    Playing {
        waveform: Box<Waveform>,
        started: bool,
        after: u32,
        ended: Option<usize>,
    },
    Asking {
        answer: Option<Answer>,
    },
    /// The step was broken off; the operator removes the cause and lets it begin again.
    BrokenOff {
        why: String,
        again: Option<NextStep>,
    },
    /// The measurement has failed; the operator reads why.
    Failed(anyhow::Error),
    Done,
}

/// A tone that sounds until a step needs another signal.
pub(super) struct HeldTone {
    pub(super) waveform: Waveform,
    pub(super) after: u32,
    pub(super) steady_frames: usize,
}
