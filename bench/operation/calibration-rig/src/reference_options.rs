//! Options of an instrument with its analog output on a spare input.

use crate::reference::{MeasuredQuantity, Reference, StatedDelay};
use clap::Args;
use config::{CalibrationFile, Config};

/// A vibrometer's or interferometer's analog output on a spare input.
#[derive(Debug, Args)]
pub struct ReferenceOptions {
    /// Spare input connected to the analog output of a vibrometer or interferometer, which gives the known amplitudes and the
    /// pickup's phase.
    #[arg(long = "reference-channel", value_name = "INPUT", conflicts_with_all = ["known_um", "known_csv", "known_at_hz", "instrument"], requires_all = ["volts_per_unit", "sensitivity"])]
    pub channel: Option<u16>,
    /// Displacement per volt at the instrument's output, µm/V.
    #[arg(
        long = "reference-um-per-v",
        value_name = "UM_PER_V",
        group = "sensitivity",
        requires = "channel",
        allow_negative_numbers = true
    )]
    pub um_per_v: Option<f64>,
    /// Velocity per volt at the instrument's output, m/s/V.
    #[arg(
        long = "reference-m-per-s-per-v",
        value_name = "M_PER_S_PER_V",
        group = "sensitivity",
        requires = "channel",
        allow_negative_numbers = true
    )]
    pub m_per_s_per_v: Option<f64>,
    /// Volts at the spare input for a full-scale sample.
    #[arg(
        long = "reference-volts-per-unit",
        value_name = "VOLTS",
        requires = "channel",
        allow_negative_numbers = true
    )]
    pub volts_per_unit: Option<f64>,
    /// Delay of the instrument's output behind the motion, µs, from its manual; without it, no phase is stored.
    #[arg(
        long = "reference-delay-us",
        value_name = "MICROSECONDS",
        requires = "channel",
        allow_negative_numbers = true
    )]
    pub delay_us: Option<f64>,
    /// Standard uncertainty of the instrument's delay, µs.
    #[arg(
        long = "reference-delay-error-us",
        value_name = "MICROSECONDS",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    pub delay_error_us: f64,
}

impl ReferenceOptions {
    /// Returns the instrument on the bench of `config`, with the inputs as compared in `calibration`, if at all; `None` without
    /// an instrument.
    ///
    /// # Errors
    /// If an option is out of its range, or the input is not spare.
    pub fn instrument(
        &self,
        config: &Config,
        calibration: &CalibrationFile,
    ) -> anyhow::Result<Option<Reference>> {
        let (Some(channel), Some(volts_per_unit)) = (self.channel, self.volts_per_unit) else {
            return Ok(None);
        };
        let follows = match (self.um_per_v, self.m_per_s_per_v) {
            (Some(um_per_v), _) => MeasuredQuantity::Displacement(um_per_v * 1e-6),
            (None, per_v) => MeasuredQuantity::Velocity(per_v.unwrap_or(f64::NAN)),
        };
        let delay = self.delay_us.map(|delay_us| StatedDelay {
            delay_s: delay_us * 1e-6,
            error_s: self.delay_error_us * 1e-6,
        });
        let input = (channel, volts_per_unit);
        Reference::new(input, follows, delay, config, calibration).map(Some)
    }
}
