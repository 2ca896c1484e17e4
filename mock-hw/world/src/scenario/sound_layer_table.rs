//! `[sound_layer]`: the software between program and sound card.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

/// A server or plug-in between the program and the sound card that changes samples without reporting it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SoundLayerTable {
    /// Rate to which the output is resampled, and from which it is resampled back, Hz; not resampled if absent.
    pub rate_hz: Option<f64>,
    /// Whether frequencies above half of that rate are filtered out before resampling; otherwise they alias.
    pub anti_alias: bool,
    /// Delay of the drive in an additional buffer on the way to the card, s.
    pub delay_s: f64,
    /// Largest further delay, drawn anew at each opening of the streams, s.
    pub delay_spread_s: f64,
    /// Converter channel carried by each channel of the input stream; missing entries are the channel of the same number.
    pub inputs: Vec<usize>,
    /// Channel that falls behind the others during a run.
    pub slip: Option<ChannelSlip>,
}

impl Default for SoundLayerTable {
    fn default() -> Self {
        Self {
            rate_hz: None,
            anti_alias: true,
            delay_s: 0.0,
            delay_spread_s: 0.0,
            inputs: Vec::new(),
            slip: None,
        }
    }
}

/// A permanent delay of one channel of the input stream.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ChannelSlip {
    /// Channel of the input stream, from 0.
    pub channel: usize,
    /// Delay, samples.
    pub samples: usize,
    /// Start of the delay, s after the sound card was switched on or its rate set.
    pub after_s: f64,
}

impl SoundLayerTable {
    /// Requires every number of the table to be in range, and channels to be below the converter's `channels`.
    pub(super) fn check(&self, channels: usize) -> Result<(), OutOfRange> {
        let last = channels.saturating_sub(1) as f64;
        if let Some(rate_hz) = self.rate_hz {
            require_range("sound_layer.rate_hz", rate_hz, 8e3, 192e3, "Hz")?;
        }
        require_range("sound_layer.delay_s", self.delay_s, 0.0, 0.2, "s")?;
        let spread_s = self.delay_spread_s;
        require_range("sound_layer.delay_spread_s", spread_s, 0.0, 0.2, "s")?;
        require_range(
            "sound_layer.inputs (entries)",
            self.inputs.len() as f64,
            0.0,
            channels as f64,
            "",
        )?;
        for &input in &self.inputs {
            require_range("sound_layer.inputs", input as f64, 0.0, last, "")?;
        }
        if let Some(slip) = &self.slip {
            require_range(
                "sound_layer.slip.channel",
                slip.channel as f64,
                0.0,
                last,
                "",
            )?;
            require_range(
                "sound_layer.slip.samples",
                slip.samples as f64,
                1.0,
                16.0,
                "samples",
            )?;
            require_range("sound_layer.slip.after_s", slip.after_s, 0.0, 1e4, "s")?;
        }
        Ok(())
    }
}
