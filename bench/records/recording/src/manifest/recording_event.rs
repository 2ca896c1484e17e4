//! Events of a recording, each at its sample.

use serde::{Deserialize, Serialize};

/// Time without a recurrence that ends a fault of an input, s: longer than a period of the modulation, since a channel
/// may clip at every crest.
pub const QUIET_S: f64 = 0.5;

/// Event at a sample of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordingEvent {
    /// Kind of event.
    pub kind: EventKind,
    /// Frame of `signals.wav` at which the event happened, from 0.
    pub sample: u64,
    /// Number of frames that the event affects, if it has a length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<u64>,
    /// Additional text for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// `frames` samples were lost and written as NaN.
    Gap,
    /// The input stream reported an overrun.
    InputXrun,
    /// The output stream reported an underrun.
    OutputXrun,
    /// Samples of drive or pickup reached the limits of the converter, within `frames`.
    Clipping,
    /// The converter delivered NaN or infinity, within `frames`.
    NonFinite,
    /// The drive was taken to zero because its read-back differed from the command or was missing.
    ReadbackMismatch,
    /// Force frames were lost, rejected by their checksum or sent twice, within `frames`; resolved to one burst of the sensor.
    ForceLost,
    /// A sensor restarted, or its readings arrived at times that disagree with its clock, within `frames`.
    SensorClock,
    /// An axis of the force sensor reached the end of its range, within `frames`.
    ForceOverRange,
    /// The encoder moved at an impossible speed, or faster than its lines were read, within `frames`.
    PositionJump,
    /// Times of `force.csv` or `position.csv` do not increase from row to row.
    TimeDisorder,
    /// The recorder's queue overflowed; the recording ends here.
    RecorderOverflow,
    /// The emergency stop took the drive to zero: it was pressed, its wire was cut, or the operator used the key.
    EmergencyStop,
    /// Another fault took the drive to zero.
    Safe,
    /// A constant offset, mains hum or a foreign tone was on drive or pickup in the preceding quarter of a second.
    Interference,
    /// The trial was aborted.
    Abort,
    /// A pause interrupted the trial.
    Pause,
    /// The session resumed with this trial after a pause, a fault or the end of the program.
    Resume,
    /// The trial was aborted to be repeated, or is a further attempt.
    Redo,
    /// A remark.
    Note,
}
