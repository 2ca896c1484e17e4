//! Origin of a recording: participant, trial, hardware and program.

use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, from_one, refused};

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

/// Trial that a recording is of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number among the practice trials or among the others, from 1.
    pub number: u32,
    /// Attempt at this trial, from 1; more after a redo.
    pub attempt: u32,
    /// Whether this is a practice trial, which is not analysed.
    pub practice: bool,
    /// Name of the condition.
    pub condition: String,
    /// Name of the protocol.
    pub protocol: String,
    /// File in the session's folder that holds the protocol as this trial followed it, such as `demo.2.toml` after an edit;
    /// absent in recordings of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub protocol_file: Option<String>,
    /// Seed of the protocol's randomisation, at most 2⁶³ − 1.
    pub seed: u64,
    /// How the recording ended; absent while it goes on, and for good if the bench was killed. Whether the trial was
    /// accepted is in the session's log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<End>,
    /// Reason of the interruption.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interruption: Option<String>,
}

impl Trial {
    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        from_one("trial.number", self.number)?;
        from_one("trial.attempt", self.attempt)?;
        if self.seed > MAX_SEED {
            return Err(refused(
                "trial.seed",
                self.seed as f64,
                &format!("0 to {MAX_SEED}"),
            ));
        }
        Ok(())
    }
}

/// How a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// All of the trial is in it.
    Completed,
    /// Broken off by the operator or by a fault.
    Interrupted,
}

/// Hardware that a recording was made with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedHardware {
    /// Audio input device.
    pub input_device: String,
    /// Audio output device.
    pub output_device: String,
    /// What tells the sound card from another one of its name: its serial number, or the port that it is plugged into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sound_card: Option<String>,
    /// Sample rate that both run at, Hz.
    pub sample_rate_hz: u32,
    /// Sample format of the input device, such as `i32`.
    pub sample_format: String,
    /// Names of what is connected to each channel of `signals.wav`, in order.
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
    /// Name of the person who waived them; absent if and only if none is waived.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waived_by: Option<String>,
    /// Whether the drive needed a dead-man switch that somebody holds; absent in recordings of earlier versions,
    /// which do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_man: Option<bool>,
    /// Safety limits that are looser than their defaults, such as `safety.readback_tolerance = 0.4 (default
    /// 0.25)`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loosened: Vec<String>,
    /// Whether the program's memory was kept from being paged out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub memory_locked: bool,
    /// Scheduling of the threads whose time counts; absent where no thread had one of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheduling: Option<RecordedScheduling>,
    /// Faults that were injected on purpose, such as `estop@12s`: the recording is of a rehearsal, not data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rehearsed: Vec<String>,
    /// What nobody has measured although the safety of a real bench rests on it, a line each: the loop's delay, the
    /// volts against a meter.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unverified: Vec<String>,
    /// The calibration in use; absent if and only if `uncalibrated`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationReference>,
}

impl RecordedHardware {
    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        from_one("hardware.sample_rate_hz", self.sample_rate_hz)?;
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

/// Scheduling of the threads whose time counts, each in words, such as `real-time priority 10`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedScheduling {
    /// The safety watch.
    pub watch: String,
    /// The output's callbacks; absent where nothing was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<String>,
    /// The input's callbacks; absent where nothing was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
}

/// Calibration that the constants of a recording come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibrationReference {
    /// Label of the calibration.
    pub label: String,
    /// Hash of the calibration file.
    pub hash: String,
    /// When and by whom the force sensor was calibrated and tared; absent if the sensor's own readings were used.
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
