//! Parts of the acquisition that depend on the carrier.

use config::Config;
use impedance::{
    ChannelScales, Demodulator, Filter, InputChannel, OUTPUT_RATE_HZ, Zm, output_rate_hz,
};

use crate::recorded_bench;

/// Demodulator and computation of Z_m for a carrier.
pub struct Tuning {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Demodulator of drive and pickup.
    pub demodulator: Demodulator<2>,
    /// Computation of Z_m.
    pub zm: Zm,
}

impl std::fmt::Debug for Tuning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Tuning to {} Hz", self.carrier_hz)
    }
}

impl Tuning {
    /// Makes the parts that a bench of `config` needs for a carrier.
    ///
    /// # Errors
    /// If sample rate and carrier do not fit each other, or a channel does not exist.
    pub fn new(config: &Config, carrier_hz: f64) -> anyhow::Result<Self> {
        let (filter, zm) = impedance_chain(config, carrier_hz)?;
        let clipping = |index: u16, clip_units: f64| InputChannel {
            channel: usize::from(index),
            clip_level: clip_units as f32,
        };
        let (on_drive, on_pickup) = (&config.channels.drive, &config.channels.pickup);
        let demodulator = Demodulator::drive_and_pickup(
            filter,
            usize::from(config.audio.input_channels),
            clipping(on_drive.index, on_drive.clip_units),
            clipping(on_pickup.index, on_pickup.clip_units),
        )?;
        Ok(Self {
            carrier_hz,
            demodulator,
            zm,
        })
    }
}

/// Returns the demodulation filter at the carrier and the computation of Z_m with the constants of `config`.
///
/// # Errors
/// If sample rate and carrier do not fit each other.
pub fn impedance_chain(config: &Config, carrier_hz: f64) -> anyhow::Result<(Filter, Zm)> {
    let filter = Filter::new(impedance::FilterSettings {
        sample_rate_hz: config.audio.rate_hz,
        carrier_hz,
        output_rate_hz: output_rate_hz(config.audio.rate_hz).unwrap_or(OUTPUT_RATE_HZ),
    })?;
    let plate = recorded_bench::plate_constants(config);
    let channels = ChannelScales {
        drive_volts_per_unit: config.channels.drive.volts_per_unit,
        pickup_metres_per_unit: config.channels.pickup.metres_per_unit,
        pickup_phase_rad: config.channels.pickup.phase_rad,
    };
    let zm = Zm::new(plate, channels, &filter)?;
    Ok((filter, zm))
}
