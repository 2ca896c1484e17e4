//! A measurement, one step at a time.

use signalgen::Waveform;

use crate::capture::Capture;
use crate::operator::{Answer, CalibrationProgress, Request};

/// A tone that is held has sounded for this long when its answer is taken, s.
pub const HELD_S: f64 = 1.0;

/// What a calibration wants next.
#[derive(Debug, Clone)]
pub enum NextStep {
    /// Silence, for so many seconds.
    Listen(f64),
    /// A waveform that ends by itself: stepped tones.
    Play(Box<Waveform>),
    /// Silence, until the operator has answered.
    Ask(Request),
    /// A tone that sounds until the operator has answered, and has sounded for [`HELD_S`]. Asked with the same tone
    /// again, it goes on without a break.
    Sound(Box<Waveform>, Request),
    /// Everything has been measured.
    Done,
}

/// What has happened at the last step.
#[derive(Debug)]
pub enum StepOutcome {
    /// Nothing yet: the first step.
    Began,
    /// What was heard while listening or playing.
    Captured(Capture),
    /// The operator's answer, and at least the last [`HELD_S`] of what was heard before it; of a tone that sounded, its
    /// only dwell is those seconds at full amplitude.
    Answered(Answer, Capture),
}

/// A measurement, one step at a time.
pub trait Procedure: Send + 'static {
    /// Decides from what has happened at the last step.
    ///
    /// # Errors
    /// When the measurement cannot be made: names why, and what to do.
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep>;

    /// How far it has come.
    fn progress(&self) -> CalibrationProgress;
}
