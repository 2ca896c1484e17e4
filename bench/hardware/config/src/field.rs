//! Devices other than the sound card and the force sensor: encoder, digital lines, sounds for the participant.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::refusal::{Refused, require_range};

/// `encoder.source`: device that counts the encoder's signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum EncoderSource {
    /// This computer, on the lines numbered in `[gpio]`.
    #[default]
    Gpio,
    /// The field box.
    FieldBox,
    /// A counter of the National Instruments card.
    Nidaqmx,
}

/// `[encoder]`: the quadrature encoder that reads the position along the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Device that counts the encoder's signals.
    #[serde(default)]
    pub source: EncoderSource,
    /// Movement per quadrature count, m; negative for an encoder that counts in the opposite direction.
    pub metres_per_count: f64,
    /// Position along the plate at which the bench starts counting, m.
    pub origin_m: f64,
}

impl Encoder {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let step_m = self.metres_per_count.abs();
        require_range("encoder.metres_per_count", step_m, 1e-7, 1e-3, "m")?;
        require_range("encoder.origin_m", self.origin_m, -10.0, 10.0, "m")
    }
}

/// Library that drives the digital lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum GpioBackend {
    /// The pins of a Raspberry Pi.
    Rppal,
    /// Any Linux board with a GPIO character device.
    Gpiocdev,
    /// The field box; its lines are fixed.
    FieldBox,
    /// The National Instruments card; inputs and outputs each use the lines of one port.
    Nidaqmx,
    /// No digital lines.
    #[default]
    None,
}

/// `[gpio]`: the digital lines, by number.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Gpio {
    /// Library that drives the lines.
    pub backend: GpioBackend,
    /// Character device; needed by `gpiocdev`.
    pub chip: Option<PathBuf>,
    /// Encoder A, line number.
    pub encoder_a: Option<u8>,
    /// Encoder B, line number.
    pub encoder_b: Option<u8>,
    /// E-stop loop, line number.
    pub estop: Option<u8>,
    /// Participant's button, line number.
    pub button: Option<u8>,
    /// Dead-man switch, line number; not the participant's button, which is pressed while the plate is driven.
    pub dead_man: Option<u8>,
    /// Amplifier enable, line number.
    pub enable: Option<u8>,
    /// Amplifier heartbeat, line number.
    pub heartbeat: Option<u8>,
}

impl Gpio {
    pub(super) fn check(&self) -> Result<(), Refused> {
        if let (GpioBackend::FieldBox, Some((key, line))) =
            (self.backend, self.lines_in_use().next())
        {
            let why = format!(
                "gpio.{key} = {line} numbers a line of this computer, and gpio.backend = \"field-box\": the lines of a field \
                 box have their places on it; remove {key}"
            );
            return Err(Refused::new(&format!("gpio.{key}"), why));
        }
        if self.backend == GpioBackend::Nidaqmx {
            for (key, line) in [("encoder_a", self.encoder_a), ("encoder_b", self.encoder_b)] {
                if line.is_some() {
                    let why = format!(
                        "gpio.{key} cannot be a line of gpio.backend = \"nidaqmx\", which is too slow to count an encoder: \
                         remove it, and set source = \"nidaqmx\" in [encoder]"
                    );
                    return Err(Refused::new(&format!("gpio.{key}"), why));
                }
            }
        }
        let mut lines: Vec<_> = self
            .lines_in_use()
            .map(|(key, line)| (self.port(key), line))
            .collect();
        lines.sort_unstable();
        if let Some(duplicate) = lines.windows(2).find(|pair| pair[0] == pair[1]) {
            let why = format!("GPIO line {} is used twice in [gpio]", duplicate[0].1);
            return Err(Refused::new("gpio", why));
        }
        if self.backend == GpioBackend::Gpiocdev && self.chip.is_none() {
            let why = "gpio.backend = \"gpiocdev\" needs gpio.chip, such as \"/dev/gpiochip0\"";
            return Err(Refused::new("gpio.backend", why.to_owned()));
        }
        Ok(())
    }

    /// Returns whether a line is on the port of the outputs; chips other than a DAQ card have a single port.
    fn port(&self, key: &str) -> bool {
        self.backend == GpioBackend::Nidaqmx && ["enable", "heartbeat"].contains(&key)
    }

    /// Returns the numbers of the wired lines.
    pub fn lines(&self) -> impl Iterator<Item = u8> {
        self.lines_in_use().map(|(_, line)| line)
    }

    /// Returns the keys and numbers of the wired lines.
    fn lines_in_use(&self) -> impl Iterator<Item = (&'static str, u8)> {
        let lines = [
            ("encoder_a", self.encoder_a),
            ("encoder_b", self.encoder_b),
            ("estop", self.estop),
            ("button", self.button),
            ("dead_man", self.dead_man),
            ("enable", self.enable),
            ("heartbeat", self.heartbeat),
        ];
        lines
            .into_iter()
            .filter_map(|(key, line)| Some((key, line?)))
    }

    /// Returns whether the bench has a line for an e-stop; a field box always has one.
    #[must_use]
    pub fn has_estop(&self) -> bool {
        self.backend == GpioBackend::FieldBox || self.estop.is_some()
    }

    /// Returns whether the bench has a line for a dead-man switch; a field box always has one.
    #[must_use]
    pub fn has_dead_man(&self) -> bool {
        self.backend == GpioBackend::FieldBox || self.dead_man.is_some()
    }
}

/// `[sound]`: cues and masking noise for the participant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Sound {
    /// Output device for cues and noise, by id or name, other than the card that drives the plate; empty for no sound.
    pub device: String,
    /// Whether start and end tones are played.
    pub cues: bool,
    /// Whether white noise masks the plate's audible squeal.
    pub masking_noise: bool,
    /// Level of tones and noise, as a share of full scale.
    pub level: f64,
}

impl Default for Sound {
    fn default() -> Self {
        Self {
            device: String::new(),
            cues: true,
            masking_noise: false,
            level: 0.2,
        }
    }
}

impl Sound {
    pub(super) fn check(&self) -> Result<(), Refused> {
        require_range("sound.level", self.level, 0.0, 1.0, "")
    }
}
