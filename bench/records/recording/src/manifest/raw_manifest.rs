//! Layout of `recording.toml`.

use serde::{Deserialize, Serialize};

use super::streams::Carrier;
use super::{
    Origin, Participant, RecordedChannels, RecordedClock, RecordedContact, RecordedHardware,
    RecordedInterval, RecordedPlate, RecordedRoom, RecordingEvent, Software, StandardErrors, Trial,
};

/// Content of `recording.toml`, before its keys are known to belong together.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Manifest"))]
#[serde(deny_unknown_fields)]
pub(super) struct RawManifest {
    /// Version of the file's layout; 1.
    pub(super) format: u32,
    /// Carrier frequency, Hz; "follows" if it moves within the recording and is read from the drive; absent if only forces were
    /// recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) carrier_hz: Option<Carrier>,
    /// Frequency of the amplitude modulation, Hz; 0 for no modulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) modulation_hz: Option<f64>,
    /// Modulation index, 0 to 1: A(t) = A_mean (1 + index · sin 2πft).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) modulation_index: Option<f64>,
    /// Channels from which the impedance is computed; absent if `envelopes.parquet` has their envelopes, or if only forces were
    /// recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) channels: Option<RecordedChannels>,
    /// Plate under the finger; absent if only forces were recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) plate: Option<RecordedPlate>,
    /// Body that touches the plate; a finger if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) contact: Option<RecordedContact>,
    /// Standard errors of the constants, from the calibration; if absent, the constants are taken as exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) standard_errors: Option<StandardErrors>,
    /// Room; if absent, its ambient pressure is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) room: Option<RecordedRoom>,
    /// Intervals of the recording with a known meaning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) intervals: Vec<RecordedInterval>,
    /// Participant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) participant: Option<Participant>,
    /// Trial, protocol, and the end of the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) trial: Option<Trial>,
    /// Hardware of the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) hardware: Option<RecordedHardware>,
    /// Program that wrote the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) software: Option<Software>,
    /// Origin, if the recording was imported from files of another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) origin: Option<Origin>,
    /// Clocks by which readings were placed in time; absent in recordings of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) clocks: Vec<RecordedClock>,
    /// Events during the recording.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) events: Vec<RecordingEvent>,
}
