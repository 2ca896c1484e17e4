//! Origin of a recording: participant, trial, hardware and program.

use serde::{Deserialize, Serialize};

use protocols::TrialLabel;

use super::manifest_error::{ManifestError, require_from_one, value_error};

/// Greatest seed: seeds are TOML integers, at most 2⁶³ − 1.
pub const MAX_SEED: u64 = i64::MAX as u64;

/// Participant of a recording, by pseudonym only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Pseudonym, such as `sub-01`.
    pub id: String,
    /// Number of this participant's session, from 1.
    pub session: u32,
}

/// Trial of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number of the trial, from 1; practice trials are numbered separately.
    pub number: u32,
    /// Number of the attempt at this trial, from 1; higher after a redo.
    pub attempt: u32,
    /// Whether this is a practice trial, which is not analysed.
    pub practice: bool,
    /// Name of the condition.
    pub condition: String,
    /// Name of the protocol.
    pub protocol: String,
    /// File in the session's folder with the protocol as followed in this trial, such as `demo.2.toml` after an edit; absent in
    /// recordings of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub protocol_file: Option<String>,
    /// Seed of the protocol's randomisation, at most 2⁶³ − 1.
    pub seed: u64,
    /// Manner in which the recording ended; absent while it is in progress, and permanently if the bench was killed. The
    /// session's log says whether the trial was accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<End>,
    /// Reason of the interruption.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interruption: Option<String>,
}

impl Trial {
    /// Returns the label of the attempt.
    #[must_use]
    pub fn label(&self) -> TrialLabel {
        TrialLabel::of_block(self.practice, self.number, self.attempt)
    }

    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        require_from_one("trial.number", self.number)?;
        require_from_one("trial.attempt", self.attempt)?;
        if self.seed > MAX_SEED {
            return Err(value_error(
                "trial.seed",
                self.seed as f64,
                &format!("0 to {MAX_SEED}"),
            ));
        }
        Ok(())
    }
}

/// Manner in which a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The whole trial was recorded.
    Completed,
    /// The operator or a fault interrupted the trial.
    Interrupted,
}

/// Hardware of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedHardware {
    /// Audio input device.
    pub input_device: String,
    /// Audio output device.
    pub output_device: String,
    /// Identification of the sound card among others of the same name: its serial number, or the port it is plugged into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sound_card: Option<String>,
    /// Sample rate of both devices, Hz.
    pub sample_rate_hz: u32,
    /// Sample format of the input device, such as `i32`.
    pub sample_format: String,
    /// Name of the signal on each channel of `signals.wav`, in order.
    pub channel_names: Vec<String>,
    /// The force sensor's port or identity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_sensor: Option<String>,
    /// The position sensor's lines or identity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_sensor: Option<String>,
    /// Whether the constants were taken from the configuration instead of a calibration.
    pub uncalibrated: bool,
    /// Names of the hardware stops that the preflight did not require, such as `estop`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waived: Vec<String>,
    /// Name of the person who waived these hardware stops; absent if and only if no stop is waived.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waived_by: Option<String>,
    /// Whether a dead-man switch had to be held during the drive; absent in recordings of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_man: Option<bool>,
    /// Safety limits that are looser than their defaults, such as `safety.readback_tolerance = 0.4 (default
    /// 0.25)`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loosened: Vec<String>,
    /// Whether the program's memory was locked against being paged out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub memory_locked: bool,
    /// Scheduling of the time-critical threads; absent if it was not set for any thread.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheduling: Option<RecordedScheduling>,
    /// Faults injected on purpose, such as `estop@12s`: the recording is a rehearsal, not data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rehearsed: Vec<String>,
    /// Values not measured although the safety of a real bench depends on them, one per line: the loop's delay, the volts
    /// against a meter.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unverified: Vec<String>,
    /// The calibration in use; absent if and only if `uncalibrated`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationReference>,
}

impl RecordedHardware {
    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        require_from_one("hardware.sample_rate_hz", self.sample_rate_hz)?;
        if self.uncalibrated == self.calibration.is_some() {
            return Err(ManifestError::Calibration {
                uncalibrated: self.uncalibrated,
            });
        }
        if self.waived.is_empty() == self.waived_by.is_some() {
            return Err(ManifestError::Waiver {
                waived: self.waived.clone(),
            });
        }
        Ok(())
    }
}

/// Scheduling of the time-critical threads, each in words, such as `real-time priority 10`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedScheduling {
    /// Scheduling of the safety watch.
    pub watch: String,
    /// Scheduling of the output's callbacks; absent if not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<String>,
    /// Scheduling of the input's callbacks; absent if not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
}

/// Calibration that supplied the constants of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibrationReference {
    /// Label of the calibration.
    pub label: String,
    /// Hash of the calibration file.
    pub hash: String,
    /// Date and operator of the calibration and tare of the force sensor; absent if the sensor's own readings were used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
}

/// Program that wrote a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Software {
    /// Name of the program.
    pub name: String,
    /// Version of the program.
    pub version: String,
}
