//! Devices beside the sound card: force sensor, encoder, digital lines, sounds for the participant.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::limits::Safety;
use super::refused::{Refused, within};
use crate::correction::Correction;
use crate::force_protocol::ForceProtocol;

/// `[force]`: the force sensor's serial line and the correction of its readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Serial port.
    pub port: PathBuf,
    /// Format on the line (`docs/force-protocol.md`).
    pub protocol: ForceProtocol,
    /// Baud rate; ignored by USB ports.
    #[serde(default = "Force::default_baud")]
    pub baud: u32,
    /// Shortest time from sampling to the first byte at the computer, s.
    #[serde(default)]
    pub latency_s: f64,
    /// Normal and lateral force, in rows, per newton that the normal and the lateral axis read, N/N.
    #[serde(default = "Force::default_matrix")]
    pub matrix: [[f64; 2]; 2],
    /// Readings without load, normal and lateral, N.
    #[serde(default)]
    pub tare_n: [f64; 2],
    /// Reading from which on an axis counts as saturated, either way, N; for sensors that do not tell so themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_n: Option<f64>,
}

impl Force {
    pub(super) fn check(&self, safety: &Safety) -> Result<(), Refused> {
        within("force.baud", f64::from(self.baud), 1200.0, 2e7, "baud")?;
        within("force.latency_s", self.latency_s, 0.0, 0.1, "s")?;
        if let Some(range_n) = self.range_n {
            within("force.range_n", range_n, 0.1, 1e3, "N")?;
        }
        self.correction()
            .require_plausible(safety.max_forces_n())
            .map_err(|implausible| Refused {
                key: None,
                why: implausible.to_string(),
            })
    }

    fn default_matrix() -> [[f64; 2]; 2] {
        Correction::default().matrix
    }

    /// Returns port and protocol: the identity that tells this sensor from another.
    #[must_use]
    pub fn identity(&self) -> String {
        let protocol = format!("{:?}", self.protocol).to_lowercase();
        format!("{}, {protocol}", self.port.display())
    }

    /// Returns the correction of its readings.
    #[must_use]
    pub fn correction(&self) -> Correction {
        Correction {
            matrix: self.matrix,
            tare_n: self.tare_n,
        }
    }

    /// Replaces the correction of its readings.
    pub(crate) fn set_correction(&mut self, correction: Correction) {
        self.matrix = correction.matrix;
        self.tare_n = correction.tare_n;
    }

    fn default_baud() -> u32 {
        2_000_000
    }
}

/// `[encoder]`: the quadrature encoder that reads the position along the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Movement per quadrature count, m; negative when the encoder counts the other way.
    pub metres_per_count: f64,
    /// Position along the plate where the bench starts counting, m.
    pub origin_m: f64,
}

impl Encoder {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let step_m = self.metres_per_count.abs();
        within("encoder.metres_per_count", step_m, 1e-7, 1e-3, "m")?;
        within("encoder.origin_m", self.origin_m, -10.0, 10.0, "m")
    }
}

/// Library that drives the digital lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GpioBackend {
    /// The pins of a Raspberry Pi.
    Rppal,
    /// Any Linux board with a GPIO character device.
    Gpiocdev,
    /// No digital lines.
    #[default]
    None,
}

/// `[gpio]`: the digital lines, by number.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
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
        let mut used: Vec<u8> = self.lines().collect();
        used.sort_unstable();
        if let Some(twice) = used.windows(2).find(|pair| pair[0] == pair[1]) {
            let why = format!("GPIO line {} is used twice in [gpio]", twice[0]);
            return Err(Refused::new("gpio", why));
        }
        if self.backend == GpioBackend::Gpiocdev && self.chip.is_none() {
            let why = "gpio.backend = \"gpiocdev\" needs gpio.chip, such as \"/dev/gpiochip0\"";
            return Err(Refused::new("gpio.backend", why.to_owned()));
        }
        Ok(())
    }

    /// Returns the numbers of the lines that are wired.
    pub fn lines(&self) -> impl Iterator<Item = u8> {
        let lines = [
            self.encoder_a,
            self.encoder_b,
            self.estop,
            self.button,
            self.dead_man,
            self.enable,
            self.heartbeat,
        ];
        lines.into_iter().flatten()
    }
}

/// `[sound]`: cues and masking noise for the participant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sound {
    /// Output device of cues and noise, by id or name: not the card that drives the plate; none when empty.
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
        within("sound.level", self.level, 0.0, 1.0, "")
    }
}
