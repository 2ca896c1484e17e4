//! A measurement as a sequence of steps.

use signalgen::Waveform;

use crate::capture::Capture;
use crate::operator::{Answer, CalibrationProgress, Request};

/// Shortest time for which a held tone has sounded before an answer is accepted, s.
pub const HELD_S: f64 = 1.0;

/// The next step of a calibration.
#[derive(Debug, Clone)]
pub enum NextStep {
    /// Captures silence for this time, s.
    Listen(f64),
    /// Plays and captures a waveform that ends, namely stepped tones.
    Play(Box<Waveform>),
    /// Asks the operator, in silence.
    Ask(Request),
    /// Asks the operator while a tone sounds, for at least [`HELD_S`]. A repetition with the same tone continues it without a
    /// break.
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
    /// The operator's answer, with a capture of at least the last [`HELD_S`] before it; the only dwell of a held tone is that
    /// time at full amplitude.
    Answered(Answer, Capture),
}

/// A measurement as a sequence of steps, free of side effects: it decides the next step from the outcome of the last one.
///
/// ```
/// use calibration_rig::operator::CalibrationProgress;
/// use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
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
    /// If the measurement is impossible; the error gives the reason and the remedy.
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep>;

    /// Returns the progress of the measurement.
    fn progress(&self) -> CalibrationProgress;
}
