//! A measurement as a sequence of steps.

use signalgen::Waveform;

use crate::capture::Capture;
use crate::operator::{Answer, CalibrationProgress, Request};

/// Time for which a held tone has sounded before an answer is taken, s.
pub const HELD_S: f64 = 1.0;

/// The next step of a calibration.
#[derive(Debug, Clone)]
pub enum NextStep {
    /// Captures silence for so many seconds.
    Listen(f64),
    /// Plays a waveform that ends by itself, stepped tones, and captures it.
    Play(Box<Waveform>),
    /// Asks the operator, in silence.
    Ask(Request),
    /// Asks the operator while a tone sounds, for at least [`HELD_S`]. Repeated with the same tone, it continues
    /// without a break.
    Sound(Box<Waveform>, Request),
    /// Ends the measurement: everything has been measured.
    Done,
}

/// Outcome of the last step.
#[derive(Debug)]
pub enum StepOutcome {
    /// The measurement has just begun.
    Began,
    /// Capture of a step that listened or played.
    Captured(Capture),
    /// The operator's answer, with a capture of at least the last [`HELD_S`] before it; the only dwell of a tone that
    /// sounded is that time at full amplitude.
    Answered(Answer, Capture),
}

/// A measurement as a sequence of steps, free of side effects: it decides from the outcome of the last step what comes
/// next.
///
/// ```
/// use calibration::operator::CalibrationProgress;
/// use calibration::procedure::{NextStep, Procedure, StepOutcome};
///
/// /// Reads the mean normal force once.
/// struct Tare(Option<f64>);
///
/// impl Procedure for Tare {
///     fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
///         Ok(match outcome {
///             StepOutcome::Captured(capture) => {
///                 self.0 = capture.mean_force_n().map(|(normal_n, _)| normal_n);
///                 NextStep::Done
///             }
///             _ => NextStep::Listen(1.0),
///         })
///     }
///
///     fn progress(&self) -> CalibrationProgress {
///         CalibrationProgress::default()
///     }
/// }
///
/// let mut tare = Tare(None);
/// assert!(matches!(tare.next(StepOutcome::Began).unwrap(), NextStep::Listen(1.0)));
/// ```
pub trait Procedure: Send + 'static {
    /// Decides the next step from the outcome of the last one.
    ///
    /// # Errors
    /// When the measurement cannot be made: the error says why and what to do.
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep>;

    /// Returns the progress of the measurement.
    fn progress(&self) -> CalibrationProgress;
}
