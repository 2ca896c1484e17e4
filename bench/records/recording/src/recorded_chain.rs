//! Channels, rate and constants of recorded signals, as the demodulator takes them.

use std::f64::consts::PI;

use impedance::{ChannelScales, ConstantError, Filter, InputChannel, Zm};
use serde::{Deserialize, Serialize};

use crate::AudioFormat;
use crate::manifest::{Manifest, RecordedSignals};

/// Deviation of the pickup from its description in the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PickupOffset {
    /// Phase to add to the stated one, rad.
    pub turn_rad: f64,
    /// Delay of its envelope, s.
    pub delay_s: f64,
}

/// Properties of a recording that are not stated but were found in its signals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalProperties {
    /// Magnitudes at which drive and pickup are clipped.
    pub clip_levels: [f32; 2],
    /// Deviation of the pickup.
    pub pickup: PickupOffset,
}

impl Default for SignalProperties {
    fn default() -> Self {
        Self {
            clip_levels: [f32::INFINITY; 2],
            pickup: PickupOffset::default(),
        }
    }
}

/// Magnitude from which a sample counts as clipped if the recording does not state it; just under full scale.
const FULL_SCALE: f64 = 0.999;

/// Returns the sampling rate of a recording's signals, Hz.
pub(crate) fn sample_rate_hz(signals: &RecordedSignals, format: AudioFormat) -> f64 {
    let header_hz = f64::from(format.sample_rate_hz);
    signals.channels.rate_hz.unwrap_or(header_hz)
}

/// Returns the channels of drive and pickup with their clipping levels.
pub(crate) fn recorded_inputs(
    manifest: &Manifest,
    signals: &RecordedSignals,
    properties: &SignalProperties,
) -> [InputChannel; 2] {
    // Older recordings of this bench do not state the clipping level, but their unit is full scale; for other
    // recordings the range is unknown.
    let default_clip_level = if manifest.hardware.is_some() {
        FULL_SCALE
    } else {
        f64::INFINITY
    };
    let input = |index: u16, clip_units: Option<f64>, observed_level: f32| InputChannel {
        channel: usize::from(index),
        clip_level: observed_level.min(clip_units.unwrap_or(default_clip_level) as f32),
    };
    let (drive, pickup) = (&signals.channels.drive, &signals.channels.pickup);
    let [drive_level, pickup_level] = properties.clip_levels;
    [
        input(drive.index, drive.clip_units, drive_level),
        input(pickup.index, pickup.clip_units, pickup_level),
    ]
}

/// Returns the Z_m converter for a recording. The recording may state a channel or the force factor with the opposite
/// sign, which becomes a phase of half a turn.
pub(crate) fn recorded_zm(
    signals: &RecordedSignals,
    properties: &SignalProperties,
    filter: &Filter,
) -> Result<Zm, ConstantError> {
    let RecordedSignals {
        channels, plate, ..
    } = signals;
    let signs = [
        channels.drive.volts_per_unit,
        channels.pickup.metres_per_unit,
        plate.force_factor_n_per_v,
    ];
    let is_inverted = signs.iter().filter(|value| **value < 0.0).count() % 2 == 1;
    let zm = Zm::new(
        plate.constants(),
        ChannelScales {
            drive_volts_per_unit: channels.drive.volts_per_unit.abs(),
            pickup_metres_per_unit: channels.pickup.metres_per_unit.abs(),
            pickup_phase_rad: channels.pickup.phase_rad
                + properties.pickup.turn_rad
                + if is_inverted { PI } else { 0.0 },
        },
        filter,
    )?;
    Ok(zm.with_pickup_delay(properties.pickup.delay_s))
}
