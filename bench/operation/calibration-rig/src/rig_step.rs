//! State of a calibration's present step.

use signalgen::Waveform;

use crate::operator::Answer;
use crate::procedure::NextStep;

/// The present step.
pub(super) enum Step {
    Settling,
    /// The previous tone is ramping to silence.
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
        programs_before: u32,
        end_frame: Option<usize>,
    },
    Asking {
        answer: Option<Answer>,
    },
    /// The step was broken off; the operator removes the cause and restarts it.
    BrokenOff {
        why: String,
        next_step: Option<NextStep>,
    },
    /// The measurement has failed; the operator reads the reason.
    Failed(anyhow::Error),
    Done,
}

/// A tone that sounds until a step needs another signal.
pub(super) struct HeldTone {
    pub(super) waveform: Waveform,
    pub(super) programs_before: u32,
    pub(super) steady_frames: usize,
}
