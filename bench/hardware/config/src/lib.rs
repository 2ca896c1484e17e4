//! Description of a bench: `bench.toml`, `calibration.toml`, and [`Effective`], the checked value made from both.
//!
//! Files are read strictly and checked once. All running code receives an [`Effective`], which never changes.

mod cal_file;
mod calibration_file;
mod calibration_order;
mod calibration_rules;
mod correction;
mod effective;
mod error;
mod field;
mod field_box;
mod force;
mod force_protocol;
mod gauges;
mod identity;
mod limits;
mod meter_check;
mod mode_across;
mod netft;
mod nidaqmx;
mod plate_constants;
mod quantity;
mod refusal;
pub mod rigs;
mod room;
mod six_axis;
mod sound_card;
#[cfg(test)]
mod template_tests;
#[cfg(test)]
mod tests;

pub use calibration_file::{
    CalibrationFile, CalibrationFileError, KeptLength, MeasuredChannels, MeasuredDelay,
    MeasuredFinger, MeasuredForce, MeasuredInput, MeasuredPickup, MeasuredPlate, MeasuredProfile,
    PROFILE_RATIOS, ProfilePlace, SweepOrigin, Uniformity, sha256,
};
pub use calibration_order::CalibrationKind;
pub use calibration_rules::{CalibrationRules, GRAVITY};
pub use correction::{Correction, Implausible, MOST_CROSSTALK};
pub use effective::{CalibrationError, Effective, InForce, unverified};
pub use error::ConfigError;
pub use field::{Encoder, EncoderSource, Gpio, GpioBackend, Sound};
pub use field_box::{BoxForce, FieldBox};
pub use force::{Force, Sensor, SerialSensor};
pub use force_protocol::ForceProtocol;
pub use gauges::Gauges;
pub use identity::{Identity, Mismatch};
pub use limits::{
    AUDIBLE_HZ, AudibleCarrier, DeadManSwitch, HEARD_BY_SOME_HZ, HardwareStop, Limits, Safety,
    UNCHECKED_V, UncheckedVolts,
};
pub use meter_check::{MeasuredOutput, MeterReads};
pub use mode_across::{
    AcrossObstacle, AcrossPlace, CosineVerdict, FARTHEST_CREST, MeasuredAcross, ModeAcross,
    WavelengthSource, contradiction, thin_plate_wavelength_m, wavelength_in_words,
};
pub use netft::Netft;
pub use nidaqmx::{CardClock, Nidaqmx, Terminals};
pub use plate_constants::Plate;
pub use quantity::{Provenance, Quantity};
pub use room::Room;
pub use six_axis::{NoForceAxis, SixAxis};
pub use sound_card::{
    Audio, AudioHost, DriveInput, InputMap, OutputChannel, PickupInput, SampleFormat,
};

use std::path::Path;

use ::safety::Pace;
use serde::{Deserialize, Serialize};

use refusal::Refused;

/// Commented template of a `bench.toml` for real hardware, to be edited.
pub const TEMPLATE: &str = include_str!("../rigs/bench-template.toml");

/// Returns the template with its optional keys enabled: the `#` before a key at the start of a line is removed.
#[must_use]
pub fn whole_template() -> String {
    let line = |line: &'static str| match line.strip_prefix('#') {
        Some(key) if key.starts_with(|c: char| c.is_ascii_lowercase()) => key,
        _ => line,
    };
    TEMPLATE.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// A bench as described by `bench.toml`: SI units, peak amplitudes.
///
/// ```
/// use config::{Config, ConfigError};
///
/// let text = config::rigs::MOCK_BENCH;
/// let config = Config::parse(text, "bench.toml").unwrap();
/// assert_eq!(config.audio.rate_hz, 192_000);
/// let wrong = Config::parse(&text.replace("rate_hz = 192000", "rate_hz = 8000"), "bench.toml");
/// assert!(matches!(wrong, Err(ConfigError::Value { line: Some(_), .. })));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Version of this file's layout; 1.
    pub format: u32,
    /// The sound card.
    pub audio: Audio,
    /// The output that drives the plate.
    pub output: OutputChannel,
    /// Inputs that read the drive and the pickup.
    pub channels: InputMap,
    /// The plate.
    pub plate: Plate,
    /// The room.
    #[serde(default, skip_serializing_if = "Room::is_empty")]
    pub room: Room,
    /// Limits of the drive.
    pub limits: Limits,
    /// Limits of the safety watch.
    #[serde(default)]
    pub safety: Safety,
    /// The force sensor; required for participant protocols.
    pub force: Option<Force>,
    /// The position encoder; required for participant protocols.
    pub encoder: Option<Encoder>,
    /// Digital lines.
    #[serde(default)]
    pub gpio: Gpio,
    /// The field box; required if another section names it as its source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_box: Option<FieldBox>,
    /// The National Instruments card; required if another section names `nidaqmx`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nidaqmx: Option<Nidaqmx>,
    /// Cues and masking noise for the participant.
    #[serde(default)]
    pub sound: Sound,
    /// Limits on the results of a calibration, and the time for which it is valid.
    #[serde(default)]
    pub calibration: CalibrationRules,
}

impl Config {
    /// Reads and checks a configuration; `file` names it in errors.
    ///
    /// # Errors
    /// [`ConfigError`] with the key, its line, the value and the allowed values.
    pub fn parse(text: &str, file: &str) -> Result<Self, ConfigError> {
        Self::parse_beside(text, file, None)
    }

    /// Reads a configuration with its other files in `folder`.
    fn parse_beside(text: &str, file: &str, folder: Option<&Path>) -> Result<Self, ConfigError> {
        let mut config: Self = strict_toml::parse(text, file)?;
        let refused = |Refused { key, why, range }| ConfigError::Value {
            file: file.to_owned(),
            line: key.and_then(|key| strict_toml::line_of(text, &key)),
            why,
            range,
        };
        if let Some(force) = &mut config.force {
            force.read_beside(folder).map_err(refused)?;
        }
        config.check().map_err(refused)?;
        Ok(config)
    }

    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// [`ConfigError::Read`] if the file cannot be read; otherwise as [`Config::parse`].
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text =
            bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES).map_err(|source| {
                ConfigError::Read {
                    path: path.to_owned(),
                    source,
                }
            })?;
        Self::parse_beside(&text, &path.display().to_string(), path.parent())
    }

    /// Returns the text of a `bench.toml`.
    ///
    /// # Errors
    /// Never for a configuration that was parsed.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Returns the lines that every screen shows for a bench with non-default safety, driven at `carrier_hz`: waived hardware
    /// stops, loosened limits, a carrier that some people hear.
    #[must_use]
    pub fn safety_notices(&self, carrier_hz: f64, pace: Pace) -> Vec<String> {
        [
            self.safety.waiver_in_words(),
            self.loosened_in_words(pace),
            self.limits.hearing_in_words(carrier_hz),
            self.limits.unchecked_in_words(),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Returns a text on the abilities and limits of a bench without a force sensor; `None` with a force sensor.
    #[must_use]
    pub fn forceless_in_words(&self) -> Option<String> {
        let text = "no force sensor ([force] in bench.toml): no force limit protects the finger, and only you can see \
                    whether the plate is clear; Z_m, amplitude and resonance can be measured; gap, friction and \
                    participants' sessions need one";
        self.force.is_none().then(|| text.to_owned())
    }

    /// Returns each value that the safety watch relies on and that is looser than its default, such as the text
    /// `safety.readback_tolerance = 0.4 (default 0.25)`.
    ///
    /// ```
    /// # let text = config::TEMPLATE.replace("silence_s = 0.05", "silence_s = 0.1");
    /// # let config = config::Config::parse(&text, "bench.toml").unwrap();
    /// assert_eq!(config.loosened(), ["safety.silence_s = 0.1 (default 0.05)"]);
    /// ```
    #[must_use]
    pub fn loosened(&self) -> Vec<String> {
        let (safety, limits, plate) = (&self.safety, &self.limits, &self.plate);
        let default = Safety::default();
        let above_default = |key, value: f64, default: f64| (key, value, default, value > default);
        let below_default = |key, value: f64, default: f64| (key, value, default, value < default);
        [
            above_default(
                "safety.max_normal_n",
                safety.max_normal_n,
                default.max_normal_n,
            ),
            above_default(
                "safety.max_lateral_n",
                safety.max_lateral_n,
                default.max_lateral_n,
            ),
            above_default(
                "safety.readback_tolerance",
                safety.readback_tolerance,
                default.readback_tolerance,
            ),
            above_default(
                "safety.readback_floor_v",
                safety.readback_floor_v,
                default.readback_floor_v,
            ),
            above_default(
                "safety.loop_latency_s",
                safety.loop_latency_s,
                default.loop_latency_s,
            ),
            above_default("safety.silence_s", safety.silence_s, default.silence_s),
            above_default(
                "safety.estop_test_hours",
                safety.estop_test_hours,
                default.estop_test_hours,
            ),
            above_default(
                "limits.amplitude_um",
                limits.amplitude_um,
                Limits::default_amplitude_um(),
            ),
            above_default(
                "limits.surface_c",
                limits.surface_c,
                Limits::default_surface_c(),
            ),
            above_default(
                "limits.driving_s_per_hour",
                limits.driving_s_per_hour(),
                Limits::PUBLISHED_DRIVING_S_PER_HOUR,
            ),
            above_default(
                "plate.heat_capacity_j_per_k",
                plate.heat_capacity_j_per_k,
                Plate::default_heat_capacity(),
            ),
            above_default(
                "plate.heat_loss_w_per_k",
                plate.heat_loss_w_per_k,
                Plate::default_heat_loss(),
            ),
            below_default("plate.room_c", plate.room_c, Plate::default_room()),
        ]
        .into_iter()
        .filter(|(_, _, _, loose)| *loose)
        .map(|(key, value, default, _)| format!("{key} = {value} (default {default})"))
        .collect()
    }

    /// Returns whether a limit is looser than its default, apart from the silence that every simulated bench allows.
    #[must_use]
    pub fn is_loosened(&self, pace: Pace) -> bool {
        let loosened = self.loosened();
        let is_usual = |text: &String| text.starts_with("safety.silence_s = ");
        loosened
            .iter()
            .any(|text| pace == Pace::Card || !is_usual(text))
    }

    fn loosened_in_words(&self, pace: Pace) -> Option<String> {
        let loosened = self.loosened().join(", ");
        if self.is_loosened(pace) {
            return Some(format!("safety limits loosened: {loosened}"));
        }
        (!loosened.is_empty()).then(|| format!("{loosened}, as always on the simulated bench"))
    }

    /// Rejects a switch that is wired but not watched, because it would be trusted without effect, and a switch that is watched
    /// but not wired, because it cannot be held.
    fn check_dead_man(&self) -> Result<(), Refused> {
        let has_lines = self.gpio.backend != GpioBackend::None;
        let wired = self.gpio.has_dead_man().then_some(self.gpio.dead_man);
        let (key, why) = match (self.safety.dead_man, wired) {
            (Some(_), None) if has_lines => (
                "safety.dead_man",
                "safety.dead_man = \"button\" needs the switch's line, gpio.dead_man",
            ),
            (None, Some(Some(_))) => (
                "gpio.dead_man",
                "gpio.dead_man names a dead-man switch, but [safety] does not use it: add dead_man = \"button\" to \
                 [safety], or remove it",
            ),
            _ => return Ok(()),
        };
        Err(Refused::new(key, why.to_owned()))
    }

    /// Returns the keys that name the field box as their source.
    fn behind_field_box(&self) -> impl Iterator<Item = &'static str> {
        let force = self.force.as_ref().map(|force| &force.sensor);
        let encoder = self.encoder.as_ref().map(|encoder| encoder.source);
        [
            ("force.source", matches!(force, Some(Sensor::FieldBox(_)))),
            ("encoder.source", encoder == Some(EncoderSource::FieldBox)),
            ("gpio.backend", self.gpio.backend == GpioBackend::FieldBox),
        ]
        .into_iter()
        .filter_map(|(key, used)| used.then_some(key))
    }

    /// Returns the field box, if any source uses it.
    #[must_use]
    pub fn used_field_box(&self) -> Option<&FieldBox> {
        let used = self.behind_field_box().next().is_some();
        self.field_box.as_ref().filter(|_| used)
    }

    /// Returns the identification of the force sensor, if any; a sensor behind a field box uses the box's.
    #[must_use]
    pub fn force_identity(&self) -> Option<String> {
        let force = self.force.as_ref()?;
        Some(force.identity(self.field_box.as_ref()))
    }

    fn check_field_box(&self) -> Result<(), Refused> {
        match (&self.field_box, self.behind_field_box().next()) {
            (Some(field_box), _) => field_box.check(),
            (None, Some(key)) => {
                let why = format!(
                    "{key} = \"field-box\" needs the box's port: add the table [field_box], such as port = \
                     \"/dev/ttyACM0\""
                );
                Err(Refused::new(key, why))
            }
            (None, None) => Ok(()),
        }
    }

    /// Requires that the card is the converter or entirely unused: lines and counter must belong to the card that drives the
    /// plate.
    fn check_nidaqmx(&self) -> Result<(), Refused> {
        let host = self.audio.host == AudioHost::Nidaqmx;
        let encoder = self.encoder.as_ref().map(|encoder| encoder.source);
        let used = [
            ("audio.host", host),
            ("encoder.source", encoder == Some(EncoderSource::Nidaqmx)),
            ("gpio.backend", self.gpio.backend == GpioBackend::Nidaqmx),
        ];
        match (&self.nidaqmx, used.into_iter().find(|(_, used)| *used)) {
            (None, Some((key, _))) => {
                let why = format!(
                    "{key} = \"nidaqmx\" needs to know the card's channels: add the table [nidaqmx], see docs/nidaqmx.md"
                );
                Err(Refused::new(key, why))
            }
            (Some(_), Some((key, _))) if !host => {
                let why = format!(
                    "{key} = \"nidaqmx\" needs audio.host = \"nidaqmx\": lines and counter are those of the card that \
                     drives the plate"
                );
                Err(Refused::new(key, why))
            }
            (Some(nidaqmx), Some(_)) => nidaqmx.check(&self.audio),
            (_, None) => Ok(()),
        }
    }

    fn check(&self) -> Result<(), Refused> {
        if self.format != 1 {
            return Err(Refused::new(
                "format",
                format!(
                    "format = {} is not known; this version reads format 1",
                    self.format
                ),
            ));
        }
        self.audio.check()?;
        self.output.check(&self.audio)?;
        self.channels.check(&self.audio)?;
        self.plate.check()?;
        self.room.check()?;
        self.limits.check()?;
        self.safety.check()?;
        if let Some(force) = &self.force {
            force.check(&self.safety, &self.audio, &self.channels)?;
        }
        if let Some(encoder) = &self.encoder {
            encoder.check()?;
        }
        self.gpio.check()?;
        self.check_field_box()?;
        self.check_nidaqmx()?;
        self.check_dead_man()?;
        self.sound.check()?;
        self.calibration.check()
    }
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
