//! `recording.toml`: what a recording is of, and how its sample values become volts and metres.
//!
//! Peak amplitudes and exp(+iωt) throughout. The tables `channels`, `plate` and `intervals` are fixed; `participant`,
//! `trial`, `hardware`, `software` and `events` are written by this bench and may be absent in a recording made elsewhere.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use impedance::PlateConstants;
pub use protocols::Direction;
use protocols::strict_toml::{self, TomlError};

/// The version of `recording.toml` that this crate writes and reads.
pub const FORMAT: u32 = 1;

/// Seeds are TOML integers: at most 2⁶³ − 1.
pub const MAX_SEED: u64 = i64::MAX as u64;

/// The content of `recording.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the file, [`FORMAT`].
    pub format: u32,
    /// Carrier frequency, Hz.
    pub carrier_hz: f64,
    /// Frequency of the amplitude modulation, Hz; 0 for none.
    pub modulation_hz: f64,
    /// Modulation index, 0 to 1: A(t) = A_mean (1 + index · sin 2πft).
    pub modulation_index: f64,
    /// The two channels that the impedance is read from.
    pub channels: Channels,
    /// The plate that the finger rests on.
    pub plate: Plate,
    /// Stretches of the recording with a known meaning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<Interval>,
    /// Who took part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<Participant>,
    /// Which trial of which protocol this is, and how it ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial: Option<Trial>,
    /// What it was recorded with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hardware: Option<Hardware>,
    /// What wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub software: Option<Software>,
    /// What happened during the recording.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
}

/// The channels of `signals.wav` by meaning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channels {
    /// Voltage across the actuators, read back.
    pub drive: DriveChannel,
    /// Displacement of the plate.
    pub pickup: PickupChannel,
}

/// The drive read back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveChannel {
    /// Channel in `signals.wav`, from 0.
    pub index: u16,
    /// Actuator volts per sample value.
    pub volts_per_unit: f64,
    /// |sample value| from which on the input clipped, where it was known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_units: Option<f64>,
}

/// The plate's displacement: x̃ = metres_per_unit · sample · exp(+i·phase_rad).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PickupChannel {
    /// Channel in `signals.wav`, from 0.
    pub index: u16,
    /// Plate displacement per sample value at the carrier, metres, peak for peak.
    pub metres_per_unit: f64,
    /// Phase of the displacement relative to the sample values, radians.
    pub phase_rad: f64,
    /// |sample value| from which on the input clipped, where it was known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_units: Option<f64>,
}

/// The plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Resonance frequency of the driven mode, Hz.
    pub resonance_hz: f64,
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Force factor γ of the actuators, N/V: f_a = γ U_a.
    pub force_factor_n_per_v: f64,
    /// Position of the plate's centre on the scale of `position.csv`, metres.
    pub centre_m: f64,
}

impl Plate {
    /// Its constants as impedances are read with. A negative force factor is a phase of half a turn, which is not among them.
    pub fn constants(&self) -> PlateConstants {
        PlateConstants {
            resonance_hz: self.resonance_hz,
            modal_mass_kg: self.modal_mass_kg,
            force_factor_n_per_v: self.force_factor_n_per_v.abs(),
        }
    }
}

/// What a stretch of a recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalKind {
    /// No finger on the plate: where Z_p is read.
    Unloaded,
    /// The finger slides.
    Exploration(Direction),
}

/// A stretch of a recording, seconds from sample 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawInterval", into = "RawInterval")]
pub struct Interval {
    /// What it is.
    pub kind: IntervalKind,
    /// Its start, seconds from sample 0.
    pub start_s: f64,
    /// Its end, seconds from sample 0.
    pub end_s: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInterval {
    kind: RawIntervalKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    direction: Option<Direction>,
    start_s: f64,
    end_s: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum RawIntervalKind {
    Unloaded,
    Exploration,
}

impl TryFrom<RawInterval> for Interval {
    type Error = &'static str;

    fn try_from(raw: RawInterval) -> Result<Self, Self::Error> {
        let kind = match (raw.kind, raw.direction) {
            (RawIntervalKind::Unloaded, None) => IntervalKind::Unloaded,
            (RawIntervalKind::Exploration, Some(direction)) => IntervalKind::Exploration(direction),
            (RawIntervalKind::Unloaded, Some(_)) => {
                return Err("an interval of kind `unloaded` has no `direction`");
            }
            (RawIntervalKind::Exploration, None) => {
                return Err(
                    "an interval of kind `exploration` needs a `direction`: `left_to_right` or `right_to_left`",
                );
            }
        };
        Ok(Self {
            kind,
            start_s: raw.start_s,
            end_s: raw.end_s,
        })
    }
}

impl Interval {
    /// An interval of the audio clock in the time of a recording whose sample 0 is at `recording_start_s` of that clock.
    #[must_use]
    pub fn relative_to(interval: protocols::Interval, recording_start_s: f64) -> Self {
        Self {
            kind: match interval.kind {
                protocols::IntervalKind::Unloaded => IntervalKind::Unloaded,
                protocols::IntervalKind::Exploration { direction } => {
                    IntervalKind::Exploration(direction)
                }
            },
            start_s: interval.start_s - recording_start_s,
            end_s: interval.end_s - recording_start_s,
        }
    }
}

impl From<Interval> for RawInterval {
    fn from(interval: Interval) -> Self {
        let (kind, direction) = match interval.kind {
            IntervalKind::Unloaded => (RawIntervalKind::Unloaded, None),
            IntervalKind::Exploration(direction) => (RawIntervalKind::Exploration, Some(direction)),
        };
        Self {
            kind,
            direction,
            start_s: interval.start_s,
            end_s: interval.end_s,
        }
    }
}

/// Who took part, by pseudonym only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Pseudonym, such as `sub-01`.
    pub id: String,
    /// Session of this participant, from 1.
    pub session: u32,
}

/// Which trial this is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Seed of the protocol's randomisation, at most [`MAX_SEED`].
    pub seed: u64,
    /// How the recording ended; absent while it goes on, and for ever if the bench was killed. Whether the trial was
    /// accepted stands in the session's log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<End>,
    /// Why it was interrupted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interruption: Option<String>,
}

/// How a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// All of the trial is in it.
    Completed,
    /// Broken off by the operator or by a fault.
    Interrupted,
}

/// What a recording was made with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hardware {
    /// Audio input device.
    pub input_device: String,
    /// Audio output device.
    pub output_device: String,
    /// Sample rate that both run at, Hz.
    pub sample_rate_hz: u32,
    /// Sample format of the input device, such as `i32`.
    pub sample_format: String,
    /// What is connected to each channel of `signals.wav`, in order.
    pub channel_names: Vec<String>,
    /// The force sensor's port or identity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_sensor: Option<String>,
    /// The position sensor's lines or identity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_sensor: Option<String>,
    /// Whether the constants were taken from the configuration instead of a calibration.
    pub uncalibrated: bool,
    /// The calibration in use; absent if and only if `uncalibrated`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
}

/// Which calibration the constants come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Its label.
    pub label: String,
    /// Hash of the calibration file.
    pub hash: String,
    /// When and by whom the force sensor was calibrated and tared; absent where its own readings were taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
}

/// What wrote a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Software {
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// Something that happened at a sample of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// Frame of `signals.wav` at which it happened, from 0.
    pub sample: u64,
    /// How many frames it concerns, where it has a length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<u64>,
    /// Further words for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

/// What can happen during a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// Samples lost, `frames` of them, written as NaN.
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
    /// Force frames lost, refused by their checksum or sent twice, within `frames`; to a burst of the sensor.
    ForceLost,
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

/// Why a `recording.toml` cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManifestReadError {
    /// Not TOML, or an unknown or missing key.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A value against a rule.
    #[error("{file}{}: {rule}", line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Rule {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key, from 1.
        line: Option<usize>,
        /// The rule.
        rule: ManifestError,
    },
}

impl ManifestReadError {
    /// Finds the line of a rule's key in the text.
    pub(super) fn at(rule: ManifestError, text: &str, file: &str) -> Self {
        Self::Rule {
            file: file.to_owned(),
            line: rule.key().and_then(|key| strict_toml::line_of(text, &key)),
            rule,
        }
    }
}

/// A rule of the manifest that is broken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// A value that TOML cannot hold, such as an integer over 2⁶³ − 1.
    #[error("recording.toml cannot be written: {reason}")]
    NotToml {
        /// The serialiser's words.
        reason: String,
    },
    /// A version that this program does not know.
    #[error("`format` is {value}, but this program reads format {FORMAT} only")]
    Format {
        /// The version in the file.
        value: u32,
    },
    /// A number out of its range, or not a number.
    #[error("`{key}` is {value}, allowed are {allowed}")]
    Value {
        /// The key, with its tables.
        key: String,
        /// Its value.
        value: f64,
        /// The allowed values in words.
        allowed: String,
    },
    /// An interval that ends before it starts.
    #[error("`intervals.{index}` ends at {end_s} s, not after its start at {start_s} s")]
    IntervalOrder {
        /// Position in the list, from 0.
        index: usize,
        /// Start, s.
        start_s: f64,
        /// End, s.
        end_s: f64,
    },
    /// Drive and pickup on the same channel.
    #[error(
        "`channels.drive.index` and `channels.pickup.index` are both {index}; they must differ"
    )]
    SameChannel {
        /// The channel.
        index: u16,
    },
    /// Calibrated without a calibration, or the reverse.
    #[error("`hardware.uncalibrated` is {uncalibrated}, but `hardware.calibration` is {}", if *.uncalibrated { "present" } else { "absent" })]
    Calibration {
        /// The flag.
        uncalibrated: bool,
    },
    /// A channel beyond those of the audio file.
    #[error("`{key}` is {index}, but signals.wav has {channels} channels, counted from 0")]
    NoSuchChannel {
        /// The key.
        key: &'static str,
        /// Its value.
        index: u16,
        /// Channels in the audio file.
        channels: u16,
    },
    /// `hardware.channel_names` does not name every channel.
    #[error("`hardware.channel_names` has {names} names, but signals.wav has {channels} channels")]
    ChannelNames {
        /// Number of names.
        names: usize,
        /// Channels in the audio file.
        channels: u16,
    },
    /// `hardware.sample_rate_hz` differs from the audio file's.
    #[error("`hardware.sample_rate_hz` is {hardware_hz}, but signals.wav has {audio_hz} Hz")]
    SampleRate {
        /// Rate in the manifest, Hz.
        hardware_hz: u32,
        /// Rate of the audio file, Hz.
        audio_hz: u32,
    },
    /// The modulated carrier does not fit under half the sample rate.
    #[error(
        "sample rate {sample_rate_hz} Hz is not above 2 · (`carrier_hz` {carrier_hz} + `modulation_hz` {modulation_hz}) = {} Hz",
        2.0 * (.carrier_hz + .modulation_hz)
    )]
    Undersampled {
        /// Sample rate, Hz.
        sample_rate_hz: u32,
        /// Carrier, Hz.
        carrier_hz: f64,
        /// Modulation, Hz.
        modulation_hz: f64,
    },
}

impl ManifestError {
    /// The key that the rule is about, dotted.
    fn key(&self) -> Option<String> {
        Some(match self {
            Self::NotToml { .. } => return None,
            Self::Format { .. } => "format".to_owned(),
            Self::Value { key, .. } => key.clone(),
            Self::IntervalOrder { index, .. } => format!("intervals.{index}.end_s"),
            Self::SameChannel { .. } => "channels.pickup.index".to_owned(),
            Self::Calibration { .. } => "hardware.uncalibrated".to_owned(),
            Self::NoSuchChannel { key, .. } => (*key).to_owned(),
            Self::ChannelNames { .. } => "hardware.channel_names".to_owned(),
            Self::SampleRate { .. } => "hardware.sample_rate_hz".to_owned(),
            Self::Undersampled { .. } => "carrier_hz".to_owned(),
        })
    }
}

impl Manifest {
    /// Reads and checks a `recording.toml`; `file` names it in errors.
    ///
    /// # Errors
    /// [`ManifestReadError`] names the key, its line, its value and what is allowed; for unknown keys the nearest known key.
    pub fn parse(text: &str, file: &str) -> Result<Self, ManifestReadError> {
        let manifest: Self = strict_toml::parse(text, file)?;
        match manifest.validate() {
            Ok(()) => Ok(manifest),
            Err(rule) => Err(ManifestReadError::at(rule, text, file)),
        }
    }

    /// The text of `recording.toml`; the same manifest always gives the same bytes.
    ///
    /// # Errors
    /// The first rule that is broken: what would not be read is not written.
    pub fn to_toml(&self) -> Result<String, ManifestError> {
        self.validate()?;
        toml::to_string(self).map_err(|error| ManifestError::NotToml {
            reason: error.to_string(),
        })
    }

    /// From when to when the force sensor was at the end of its range, s.
    #[must_use]
    pub fn saturated_s(&self, sample_rate_hz: u32) -> Vec<(f64, f64)> {
        let time_s = |sample: u64| sample as f64 / f64::from(sample_rate_hz);
        let events = self.events.iter();
        events
            .filter(|event| event.kind == EventKind::ForceOverRange)
            .map(|event| {
                let end = event.sample + event.frames.unwrap_or(1);
                (time_s(event.sample), time_s(end))
            })
            .collect()
    }

    /// Checks every rule that needs nothing but the manifest.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn validate(&self) -> Result<(), ManifestError> {
        if self.format != FORMAT {
            return Err(ManifestError::Format { value: self.format });
        }
        positive("carrier_hz", self.carrier_hz)?;
        not_negative("modulation_hz", self.modulation_hz)?;
        within("modulation_index", self.modulation_index, 0.0..=1.0)?;
        not_zero(
            "channels.drive.volts_per_unit",
            self.channels.drive.volts_per_unit,
        )?;
        not_zero(
            "channels.pickup.metres_per_unit",
            self.channels.pickup.metres_per_unit,
        )?;
        finite("channels.pickup.phase_rad", self.channels.pickup.phase_rad)?;
        if self.channels.drive.index == self.channels.pickup.index {
            return Err(ManifestError::SameChannel {
                index: self.channels.drive.index,
            });
        }
        positive("plate.resonance_hz", self.plate.resonance_hz)?;
        positive("plate.modal_mass_kg", self.plate.modal_mass_kg)?;
        not_zero(
            "plate.force_factor_n_per_v",
            self.plate.force_factor_n_per_v,
        )?;
        finite("plate.centre_m", self.plate.centre_m)?;
        for (index, interval) in self.intervals.iter().enumerate() {
            interval.validate(index)?;
        }
        if let Some(participant) = &self.participant {
            from_one("participant.session", participant.session)?;
        }
        if let Some(trial) = &self.trial {
            trial.validate()?;
        }
        if let Some(hardware) = &self.hardware {
            hardware.validate()?;
        }
        Ok(())
    }

    /// Checks the manifest against the audio that it describes.
    ///
    /// # Errors
    /// A channel beyond the last, a sample rate that differs, or one too low for the modulated carrier.
    pub fn validate_audio(
        &self,
        sample_rate_hz: u32,
        channel_count: u16,
    ) -> Result<(), ManifestError> {
        for (key, index) in [
            ("channels.drive.index", self.channels.drive.index),
            ("channels.pickup.index", self.channels.pickup.index),
        ] {
            if index >= channel_count {
                return Err(ManifestError::NoSuchChannel {
                    key,
                    index,
                    channels: channel_count,
                });
            }
        }
        if f64::from(sample_rate_hz) <= 2.0 * (self.carrier_hz + self.modulation_hz) {
            return Err(ManifestError::Undersampled {
                sample_rate_hz,
                carrier_hz: self.carrier_hz,
                modulation_hz: self.modulation_hz,
            });
        }
        if let Some(hardware) = &self.hardware {
            if hardware.sample_rate_hz != sample_rate_hz {
                return Err(ManifestError::SampleRate {
                    hardware_hz: hardware.sample_rate_hz,
                    audio_hz: sample_rate_hz,
                });
            }
            if hardware.channel_names.len() != usize::from(channel_count) {
                return Err(ManifestError::ChannelNames {
                    names: hardware.channel_names.len(),
                    channels: channel_count,
                });
            }
        }
        Ok(())
    }
}

impl Interval {
    pub(super) fn validate(&self, index: usize) -> Result<(), ManifestError> {
        not_negative(&format!("intervals.{index}.start_s"), self.start_s)?;
        finite(&format!("intervals.{index}.end_s"), self.end_s)?;
        if self.end_s <= self.start_s {
            return Err(ManifestError::IntervalOrder {
                index,
                start_s: self.start_s,
                end_s: self.end_s,
            });
        }
        Ok(())
    }
}

impl Trial {
    fn validate(&self) -> Result<(), ManifestError> {
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

impl Hardware {
    fn validate(&self) -> Result<(), ManifestError> {
        from_one("hardware.sample_rate_hz", self.sample_rate_hz)?;
        if self.uncalibrated == self.calibration.is_some() {
            return Err(ManifestError::Calibration {
                uncalibrated: self.uncalibrated,
            });
        }
        Ok(())
    }
}

fn refused(key: &str, value: f64, allowed: &str) -> ManifestError {
    ManifestError::Value {
        key: key.to_owned(),
        value,
        allowed: allowed.to_owned(),
    }
}

fn require(holds: bool, key: &str, value: f64, allowed: &str) -> Result<(), ManifestError> {
    if holds {
        Ok(())
    } else {
        Err(refused(key, value, allowed))
    }
}

fn finite(key: &str, value: f64) -> Result<(), ManifestError> {
    require(value.is_finite(), key, value, "finite numbers")
}

fn positive(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value > 0.0,
        key,
        value,
        "finite numbers above 0",
    )
}

fn not_negative(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value >= 0.0,
        key,
        value,
        "finite numbers from 0",
    )
}

fn not_zero(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value != 0.0,
        key,
        value,
        "finite numbers other than 0",
    )
}

fn within(key: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), ManifestError> {
    require(
        range.contains(&value),
        key,
        value,
        &format!("{} to {}", range.start(), range.end()),
    )
}

fn from_one(key: &str, value: u32) -> Result<(), ManifestError> {
    require(value >= 1, key, f64::from(value), "whole numbers from 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the file format's description, written by hand as a laboratory would.
    const BY_HAND: &str = r#"format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95

[channels.drive]              # voltage across the actuators
index = 0
volts_per_unit = 1.0

[channels.pickup]
index = 1
metres_per_unit = 2.0e-6
phase_rad = 0.0

[plate]
resonance_hz = 35000.0
modal_mass_kg = 0.008
force_factor_n_per_v = 0.13
centre_m = 0.0525

[[intervals]]
kind = "unloaded"
start_s = 0.2
end_s = 1.0

[[intervals]]
kind = "exploration"
direction = "left_to_right"
start_s = 1.4
end_s = 3.1
"#;

    const OWN_TABLES: &str = r#"
[participant]
id = "sub-01"
session = 1

[trial]
number = 3
attempt = 1
practice = false
condition = "6 Hz"
protocol = "huloux2021"
seed = 42

[hardware]
input_device = "hw:1,0"
output_device = "hw:1,0"
sample_rate_hz = 192000
sample_format = "i32"
channel_names = ["drive", "pickup"]
uncalibrated = true

[software]
name = "friction-bench"
version = "0.1.0"

[[events]]
kind = "gap"
sample = 1000
frames = 64
"#;

    fn parse(text: &str) -> Result<Manifest, ManifestReadError> {
        Manifest::parse(text, "recording.toml")
    }

    fn full() -> Manifest {
        parse(&format!("{BY_HAND}{OWN_TABLES}")).unwrap()
    }

    #[test]
    fn a_recording_made_elsewhere_needs_the_fixed_tables_only() {
        let manifest = parse(BY_HAND).unwrap();
        assert_eq!(manifest.channels.pickup.metres_per_unit, 2.0e-6);
        assert_eq!(
            manifest.intervals[1].kind,
            IntervalKind::Exploration(Direction::LeftToRight)
        );
        assert_eq!(manifest.trial, None);
    }

    #[test]
    fn what_is_written_reads_back_and_always_has_the_same_bytes() {
        let mut manifest = full();
        // 0.1 + 0.2 and 1e-300 need every digit of a double.
        manifest.plate.centre_m = 0.1 + 0.2;
        manifest.channels.pickup.metres_per_unit = 1e-300;
        let text = manifest.to_toml().unwrap();
        assert_eq!(parse(&text).unwrap(), manifest);
        assert_eq!(manifest.clone().to_toml().unwrap(), text);
    }

    #[test]
    fn unknown_keys_are_named_with_line_and_nearest_key_in_every_table() {
        let whole = format!("{BY_HAND}{OWN_TABLES}");
        for (right, wrong, nearest) in [
            ("carrier_hz =", "carier_hz =", "carrier_hz"),
            ("volts_per_unit", "volt_per_unit", "volts_per_unit"),
            ("phase_rad", "phase_deg", "phase_rad"),
            ("modal_mass_kg", "modal_mass_g", "modal_mass_kg"),
            ("end_s", "end_ms", "end_s"),
            ("session = 1", "sesion = 1", "session"),
            ("condition", "conditions", "condition"),
            ("sample_format", "sample_fromat", "sample_format"),
            ("version =", "versoin =", "version"),
            ("frames = 64", "frame = 64", "frames"),
        ] {
            let text = whole.replacen(right, wrong, 1);
            let wrong_line = text.lines().position(|l| l.contains(wrong)).unwrap() + 1;
            match parse(&text).unwrap_err() {
                ManifestReadError::Toml(TomlError::UnknownKey {
                    line, nearest: n, ..
                }) => assert_eq!((line, n.as_deref()), (wrong_line, Some(nearest)), "{wrong}"),
                other => panic!("{wrong}: {other}"),
            }
        }
    }

    #[test]
    fn a_missing_key_is_named() {
        let error = parse(&BY_HAND.replace("centre_m = 0.0525\n", "")).unwrap_err();
        assert!(error.to_string().contains("centre_m"), "{error}");
    }

    #[test]
    fn every_rule_refuses_with_line_value_and_range() {
        let whole = format!("{BY_HAND}{OWN_TABLES}");
        for (right, wrong, words) in [
            ("format = 1", "format = 2", "reads format 1 only"),
            ("carrier_hz = 35000.0", "carrier_hz = 0.0", "above 0"),
            ("modulation_hz = 6.0", "modulation_hz = -6.0", "from 0"),
            (
                "modulation_index = 0.95",
                "modulation_index = 1.01",
                "0 to 1",
            ),
            (
                "modulation_index = 0.95",
                "modulation_index = nan",
                "0 to 1",
            ),
            (
                "volts_per_unit = 1.0",
                "volts_per_unit = 0.0",
                "other than 0",
            ),
            (
                "metres_per_unit = 2.0e-6",
                "metres_per_unit = inf",
                "other than 0",
            ),
            ("phase_rad = 0.0", "phase_rad = nan", "finite"),
            ("index = 1", "index = 0", "must differ"),
            ("resonance_hz = 35000.0", "resonance_hz = -1.0", "above 0"),
            ("modal_mass_kg = 0.008", "modal_mass_kg = 0.0", "above 0"),
            ("centre_m = 0.0525", "centre_m = inf", "finite"),
            ("start_s = 0.2", "start_s = -0.2", "from 0"),
            ("end_s = 3.1", "end_s = 1.4", "not after its start"),
            ("session = 1", "session = 0", "from 1"),
            ("attempt = 1", "attempt = 0", "from 1"),
            ("uncalibrated = true", "uncalibrated = false", "absent"),
        ] {
            assert!(whole.contains(right), "{right}");
            let text = whole.replacen(right, wrong, 1);
            let error = parse(&text).unwrap_err().to_string();
            assert!(error.contains(words), "{wrong}: {error}");
            assert!(error.contains(", line "), "{wrong}: {error}");
        }
    }

    #[test]
    fn direction_belongs_to_explorations_and_to_them_alone() {
        let without = BY_HAND.replace("direction = \"left_to_right\"\n", "");
        assert!(
            parse(&without)
                .unwrap_err()
                .to_string()
                .contains("needs a `direction`")
        );
        let with = BY_HAND.replace(
            "kind = \"unloaded\"\n",
            "kind = \"unloaded\"\ndirection = \"left_to_right\"\n",
        );
        assert!(
            parse(&with)
                .unwrap_err()
                .to_string()
                .contains("has no `direction`")
        );
    }

    #[test]
    fn the_largest_seed_is_that_of_a_toml_integer() {
        let mut manifest = full();
        let mut set_seed = |seed| {
            if let Some(trial) = &mut manifest.trial {
                trial.seed = seed;
            }
            manifest.to_toml()
        };
        assert!(set_seed(MAX_SEED).is_ok());
        assert!(set_seed(MAX_SEED + 1).is_err());
    }

    #[test]
    fn audio_must_fit_the_description() {
        let manifest = full();
        assert_eq!(manifest.validate_audio(192_000, 2), Ok(()));
        assert!(matches!(
            manifest.validate_audio(192_000, 1),
            Err(ManifestError::NoSuchChannel { index: 1, .. })
        ));
        assert!(matches!(
            manifest.validate_audio(192_000, 4),
            Err(ManifestError::ChannelNames { names: 2, .. })
        ));
        assert!(matches!(
            manifest.validate_audio(96_000, 2),
            Err(ManifestError::SampleRate { .. })
        ));
        let by_hand = parse(BY_HAND).unwrap();
        // 2 · (35 000 + 6) Hz is just too low; one more is enough.
        let error = by_hand.validate_audio(70_012, 2).unwrap_err();
        assert!(error.to_string().contains("= 70012 Hz"), "{error}");
        assert_eq!(by_hand.validate_audio(70_013, 2), Ok(()));
    }
}
