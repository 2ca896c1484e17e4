//! Layout of `recording.toml`.

use serde::{Deserialize, Serialize};

use super::manifest_error::ManifestError;
use super::streams::{Carrier, StreamKeys, Streams};
use super::{
    Manifest, Origin, Participant, RecordedChannels, RecordedClock, RecordedContact,
    RecordedHardware, RecordedInterval, RecordedPlate, RecordedRoom, RecordingEvent, Software,
    StandardErrors, Trial,
};

/// Content of `recording.toml`, before its keys are known to belong together.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Manifest"))]
#[serde(deny_unknown_fields)]
pub(super) struct RawManifest {
    /// Version of the file's layout; 1.
    format: u32,
    /// Carrier frequency, Hz; "follows" if it moves within the recording and is read from the drive; absent if only forces were
    /// recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    carrier_hz: Option<Carrier>,
    /// Frequency of the amplitude modulation, Hz; 0 for no modulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modulation_hz: Option<f64>,
    /// Modulation index, 0 to 1: A(t) = A_mean (1 + index · sin 2πft).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modulation_index: Option<f64>,
    /// Channels from which the impedance is computed; absent if `envelopes.parquet` has their envelopes, or if only forces were
    /// recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    channels: Option<RecordedChannels>,
    /// Plate under the finger; absent if only forces were recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    plate: Option<RecordedPlate>,
    /// Body that touches the plate; a finger if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contact: Option<RecordedContact>,
    /// Standard errors of the constants, from the calibration; if absent, the constants are taken as exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    standard_errors: Option<StandardErrors>,
    /// Room; if absent, its ambient pressure is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    room: Option<RecordedRoom>,
    /// Intervals of the recording with a known meaning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    intervals: Vec<RecordedInterval>,
    /// Participant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    participant: Option<Participant>,
    /// Trial, protocol, and the end of the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    trial: Option<Trial>,
    /// Hardware of the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hardware: Option<RecordedHardware>,
    /// Program that wrote the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    software: Option<Software>,
    /// Origin, if the recording was imported from files of another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<Origin>,
    /// Clocks by which readings were placed in time; absent in recordings of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    clocks: Vec<RecordedClock>,
    /// Events during the recording.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    events: Vec<RecordingEvent>,
}

impl TryFrom<RawManifest> for Manifest {
    type Error = ManifestError;

    fn try_from(raw: RawManifest) -> Result<Self, ManifestError> {
        // An unsupported version is named before keys that it may not have.
        super::require_format(raw.format)?;
        let streams = Streams::from_keys(StreamKeys {
            carrier: raw.carrier_hz,
            modulation_hz: raw.modulation_hz,
            modulation_index: raw.modulation_index,
            channels: raw.channels,
            plate: raw.plate,
        })?;
        Ok(Self {
            format: raw.format,
            streams,
            contact: raw.contact.unwrap_or_default(),
            standard_errors: raw.standard_errors,
            room: raw.room,
            intervals: raw.intervals,
            participant: raw.participant,
            trial: raw.trial,
            hardware: raw.hardware,
            software: raw.software,
            origin: raw.origin,
            clocks: raw.clocks,
            events: raw.events,
        })
    }
}

impl From<Manifest> for RawManifest {
    fn from(manifest: Manifest) -> Self {
        let keys = manifest.streams.into_keys();
        Self {
            format: manifest.format,
            carrier_hz: keys.carrier,
            modulation_hz: keys.modulation_hz,
            modulation_index: keys.modulation_index,
            channels: keys.channels,
            plate: keys.plate,
            contact: (manifest.contact != RecordedContact::default()).then_some(manifest.contact),
            standard_errors: manifest.standard_errors,
            room: manifest.room,
            intervals: manifest.intervals,
            participant: manifest.participant,
            trial: manifest.trial,
            hardware: manifest.hardware,
            software: manifest.software,
            origin: manifest.origin,
            clocks: manifest.clocks,
            events: manifest.events,
        }
    }
}
