//! `[converter]`: the inputs of the sound card.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::ranges::all_within;

/// The sound card's inputs.
///
/// Channel 0 reads the actuator voltage back, channel 1 the pickup, channel 2 the generator's output; others are quiet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ConverterTable {
    /// Number of input channels.
    pub channels: usize,
    /// Sample formats that the card offers in either direction.
    pub formats: Vec<OfferedFormat>,
    /// Actuator volts per sample value on channel 0.
    pub readback_volts_per_unit: f64,
    /// Resolution, bits; full scale is ±1.
    pub bits: u32,
    /// Magnitude at which the input clips.
    pub clip_units: f64,
    /// One-sided density of white noise, sample units per √Hz.
    pub noise_units_per_sqrt_hz: f64,
    /// Constant offset of every channel, sample units.
    pub offset_units: f64,
    /// Sensitivity of each channel relative to nominal, negative if its wires are swapped; missing entries are 1.
    pub gains: Vec<f64>,
    /// Fraction of the signal of channel 0 that leaks into the other channels.
    pub crosstalk: f64,
    /// Delay of each channel's sampling instant from nominal, in samples; missing entries are 0.
    pub skew_samples: Vec<f64>,
    /// Excess of the sample clock's rate over nominal, ppm.
    pub clock_ppm: f64,
}

impl Default for ConverterTable {
    fn default() -> Self {
        Self {
            channels: 4,
            formats: vec![OfferedFormat::F32, OfferedFormat::I32, OfferedFormat::I16],
            readback_volts_per_unit: 60.0,
            bits: 24,
            clip_units: 1.0,
            noise_units_per_sqrt_hz: 3.0e-8,
            offset_units: 0.0,
            gains: Vec::new(),
            crosstalk: 1.0e-4,
            skew_samples: Vec::new(),
            clock_ppm: 0.0,
        }
    }
}

/// Sample formats that a sound card may offer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "SampleFormat"))]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum OfferedFormat {
    F32,
    I32,
    I16,
    U8,
    I64,
}

impl ConverterTable {
    /// Returns the sensitivity of channel `index` relative to nominal.
    #[must_use]
    pub fn gain(&self, index: usize) -> f64 {
        self.gains.get(index).copied().unwrap_or(1.0)
    }

    /// Returns the delay of the sampling instant of channel `index` from nominal, in samples.
    #[must_use]
    pub fn skew(&self, index: usize) -> f64 {
        self.skew_samples.get(index).copied().unwrap_or(0.0)
    }

    /// Requires every number of the table to be in range, and no list to be longer than the number of channels.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        let channels = self.channels as f64;
        require_range("converter.channels", channels, 2.0, 32.0, "")?;
        all_within! { "converter", self,
            readback_volts_per_unit: 0.1, 1e4, "V";
            bits: 8.0, 32.0, "";
            clip_units: 1e-3, 1.0, "";
            noise_units_per_sqrt_hz: 0.0, 1e-3, "1/√Hz";
            offset_units: -1.0, 1.0, "";
            crosstalk: -1.0, 1.0, "";
            clock_ppm: -1e3, 1e3, "ppm";
        }
        for &gain in &self.gains {
            require_range("converter.gains", gain, -100.0, 100.0, "")?;
        }
        for &skew in &self.skew_samples {
            require_range("converter.skew_samples", skew, -4.0, 4.0, "samples")?;
        }
        for (key, entries, low, high) in [
            ("converter.gains (entries)", self.gains.len(), 0.0, channels),
            (
                "converter.skew_samples (entries)",
                self.skew_samples.len(),
                0.0,
                channels,
            ),
            ("converter.formats (entries)", self.formats.len(), 1.0, 5.0),
        ] {
            require_range(key, entries as f64, low, high, "")?;
        }
        Ok(())
    }
}
