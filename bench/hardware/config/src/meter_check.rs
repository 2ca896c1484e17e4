//! `[output]` of `calibration.toml`: the bench's volts against an independent meter.

use serde::{Deserialize, Serialize};

use crate::quantity::{Provenance, Quantity};

/// Quantity of a sine that a meter reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MeterReads {
    /// Root mean square: a multimeter.
    Rms,
    /// Peak: an oscilloscope's cursor from zero.
    Peak,
    /// Peak to peak: an oscilloscope.
    PeakToPeak,
}

impl MeterReads {
    /// Returns the ratio of a sine's peak to the meter's reading.
    #[must_use]
    pub fn peak_per_reading(self) -> f64 {
        match self {
            Self::Rms => std::f64::consts::SQRT_2,
            Self::Peak => 1.0,
            Self::PeakToPeak => 0.5,
        }
    }

    /// Returns the unit of the readings that the operator types.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Rms => "V RMS",
            Self::Peak => "V peak",
            Self::PeakToPeak => "V peak to peak",
        }
    }
}

/// `[output]`: the volts that the bench commands and reads back, compared with an independent meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredOutput {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Name of the meter, as typed.
    pub meter: String,
    /// Quantity of a sine that the meter reads.
    pub reads: MeterReads,
    /// Relative standard uncertainty of the meter, as typed.
    pub meter_accuracy: f64,
    /// Frequency of the tones, Hz.
    pub tone_hz: f64,
    /// Carrier for which the factors are valid, Hz.
    pub carrier_hz: f64,
    /// Volts by the meter per volt commanded at the carrier, dimensionless.
    pub per_commanded: Quantity,
    /// Volts by the meter per volt read back, dimensionless.
    pub per_read_back: Quantity,
    /// Largest residual over the largest reading of the meter.
    pub nonlinearity: f64,
    /// Number of levels.
    pub points: usize,
    /// Highest level, V peak by the meter.
    pub highest_v: f64,
}
