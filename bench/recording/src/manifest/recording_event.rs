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
    /// Number of frames that the event concerns, if it has a length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<u64>,
    /// Further text for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// Samples were lost, `frames` of them, and written as NaN.
    Gap,
    /// The input stream reported an overrun.
    InputXrun,
    /// The output stream reported an underrun.
    OutputXrun,
    /// Samples of drive or pickup at the limits of the converter, within `frames`.
    Clipping,
    /// NaN or infinity came from the converter, within `frames`.
    NonFinite,
    /// The drive was taken to zero because its read-back differed from the command, or stayed away.
    ReadbackMismatch,
    /// Force frames were lost, rejected by their checksum or sent twice, within `frames`; resolved to a burst of the
    /// sensor.
    ForceLost,
    /// A sensor restarted, or its readings arrive from where its clock does not place them, within `frames`.
    SensorClock,
    /// An axis of the force sensor at the end of its range, within `frames`.
    ForceOverRange,
    /// The encoder moved at an impossible speed, or faster than its lines were read, within `frames`.
    PositionJump,
    /// Rows of `force.csv` or `position.csv` whose time does not increase.
    TimeDisorder,
    /// The recorder's queue overflowed; the recording ends here.
    RecorderOverflow,
    /// The drive was taken to zero by the emergency stop: pressed, its wire cut, or the operator's key.
    EmergencyStop,
    /// The drive was taken to zero by another fault.
    Safe,
    /// A constant offset, mains hum or a foreign tone on drive or pickup, seen in the quarter of a second before.
    Interference,
    /// The trial was broken off.
    Abort,
    /// The trial was broken off by a pause.
    Pause,
    /// The session went on with this trial after a pause, a fault or the program's end.
    Resume,
    /// The trial was broken off to be done again, or is an attempt after another one.
    Redo,
    /// A remark.
    Note,
}
