//! `bench.toml`: the hardware of one bench. Read strictly, checked once, then never changed.

mod audio;
mod calibration;
mod field;
mod limits;
mod plate;
mod range;
#[cfg(test)]
mod tests;

pub use audio::{Audio, AudioHost, Channels, DriveChannel, Output, PickupChannel, SampleFormat};
pub use calibration::{Calibration, GRAVITY};
pub use field::{Encoder, Force, Gpio, GpioBackend, Sound};
pub use limits::{Limits, Safety};
pub use plate::Plate;

use std::path::Path;

use anyhow::{Context, anyhow};
use serde::{Deserialize, Serialize};

use range::Refused;

/// The bench as its file describes it. Every number is SI, peak for peak.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Version of this file's layout; 1.
    pub format: u32,
    /// The sound card.
    pub audio: Audio,
    /// The driven output.
    pub output: Output,
    /// What is wired to the inputs.
    pub channels: Channels,
    /// The plate.
    pub plate: Plate,
    /// Limits of the drive.
    pub limits: Limits,
    /// Limits of the safety watch.
    #[serde(default)]
    pub safety: Safety,
    /// The force sensor; without it there is no participant protocol.
    pub force: Option<Force>,
    /// The position encoder; without it there is no participant protocol.
    pub encoder: Option<Encoder>,
    /// Digital lines.
    #[serde(default)]
    pub gpio: Gpio,
    /// Cues and masking noise for the participant.
    #[serde(default)]
    pub sound: Sound,
    /// What a calibration must reach, and how long it holds.
    #[serde(default)]
    pub calibration: Calibration,
}

impl Config {
    /// Reads and checks a configuration.
    ///
    /// # Errors
    /// Names the key, its line, the value and what is allowed.
    pub fn parse(text: &str, file: &str) -> anyhow::Result<Self> {
        let config: Self = strict::parse(text, file)?;
        config.check().map_err(|Refused { key, why }| {
            match key.and_then(|key| strict::line_of(text, &key)) {
                Some(line) => anyhow!("{file}, line {line}: {why}"),
                None => anyhow!("{file}: {why}"),
            }
        })?;
        Ok(config)
    }

    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// As [`Config::parse`]; a missing file names the command that writes one.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| {
            format!(
                "cannot read {}: describe your hardware in it; `friction-bench run --mock --print-config > bench.toml` writes one to start from",
                path.display()
            )
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// The file's text.
    ///
    /// # Errors
    /// Never for a configuration that was parsed.
    pub fn to_toml(&self) -> anyhow::Result<String> {
        toml::to_string(self).context("the configuration cannot be written as TOML")
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
        self.limits.check()?;
        self.safety.check()?;
        if let Some(force) = &self.force {
            force.check(&self.safety)?;
        }
        if let Some(encoder) = &self.encoder {
            encoder.check()?;
        }
        self.gpio.check()?;
        self.sound.check()?;
        self.calibration.check()
    }
}
