//! Coarse scan of the unloaded plate's response: drive and pickup at tones about a frequency.

use std::f64::consts::PI;

use anyhow::bail;
use config::{Config, InputMap};
use metrology::plate_fit::Response;
use metrology::tone::SteadyTone;
use signalgen::{ToneList, Waveform};

use calibration_rig::capture::Capture;
use calibration_rig::procedure::NextStep;

/// Level of the coarse scan, V peak: harmless at any resonance.
pub(super) const LOOK_V: f64 = 2.0;
/// Number of tones of the coarse scan.
pub(super) const LOOK_TONES: usize = 41;
/// Distance between the tones of the coarse scan, Hz: a plate with Q = 350 has a bandwidth of 100 Hz.
pub(super) const LOOK_STEP_HZ: f64 = 40.0;
/// Length of each tone of the coarse scan, s.
const LOOK_DWELL_S: f64 = 0.05;
/// Settling time at the start of each tone, s.
const LOOK_SETTLE_S: f64 = 0.025;
/// Number of time constants 2Q/ω after which the previous tone has decayed: e⁻¹⁸ = 1.5e-8.
pub(super) const SETTLE_TIME_CONSTANTS: f64 = 18.0;
/// Largest target reading of the pickup, of full scale.
pub(super) const FULLEST: f64 = 0.8;

/// Returns the step that plays the coarse scan about `about_hz`.
pub(super) fn look(about_hz: f64, config: &Config) -> anyhow::Result<NextStep> {
    let tones: Vec<f64> = (0..LOOK_TONES)
        .map(|i| about_hz + LOOK_STEP_HZ * (i as f64 - (LOOK_TONES / 2) as f64))
        .collect();
    Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
        tones: ToneList::new(&tones)?,
        dwell_s: LOOK_DWELL_S,
        amplitude_v: LOOK_V.min(config.limits.drive_v),
    })))
}

/// Returns the responses of the coarse scan.
pub(super) fn look_responses(capture: &Capture, config: &Config) -> anyhow::Result<Vec<Response>> {
    responses(capture, config, LOOK_SETTLE_S)
}

/// Returns the settling time of the plate, s.
pub(super) fn settle_s(resonance_hz: f64, quality: f64) -> f64 {
    SETTLE_TIME_CONSTANTS * quality / (PI * resonance_hz)
}

/// Returns the pickup's reading per actuator volt at the resonance, units/V.
pub(super) fn peak_units_per_v(look: &[Response], config: &Config) -> f64 {
    look.iter().map(|r| r.ratio.norm()).fold(0.0, f64::max) / config.channels.drive.volts_per_unit
}

/// Returns the highest level at which the amplitude, the pickup's range and the drive stay within their limits, V peak.
#[must_use]
pub fn highest_level_v(units_per_v: f64, metres_per_unit: f64, config: &Config) -> f64 {
    let amplitude_limit_v =
        0.9 * config.calibration.max_amplitude_m / (units_per_v * metres_per_unit);
    let range_limit_v = FULLEST / units_per_v;
    amplitude_limit_v
        .min(range_limit_v)
        .min(config.limits.drive_v)
}

/// Requires that neither input is saturated.
pub(super) fn require_unsaturated(
    drive: &SteadyTone,
    pickup: &SteadyTone,
    channels: &InputMap,
    carrier_hz: f64,
) -> anyhow::Result<()> {
    for (input, tone, clip_units) in [
        ("drive", drive, channels.drive.clip_units),
        ("pickup", pickup, channels.pickup.clip_units),
    ] {
        if tone.peak >= clip_units {
            bail!(
                "the {input}'s input is saturated at {carrier_hz:.0} Hz: lower the drive's level or the gain of the input"
            );
        }
    }
    Ok(())
}

/// Smallest ratio of the carrier's amplitude to the rest of the drive's input.
const LEAST_RATIO: f64 = 3.0;

/// Returns the pickup's response to the drive at each captured tone, from `settle_s` after its start.
///
/// # Errors
/// If an input is saturated, or the carrier does not survive the loop.
pub fn responses(
    capture: &Capture,
    config: &Config,
    settle_s: f64,
) -> anyhow::Result<Vec<Response>> {
    let channels = &config.channels;
    capture
        .dwells
        .iter()
        .map(|dwell| {
            let drive = capture.tone(dwell, channels.drive.index, settle_s)?;
            let pickup = capture.tone(dwell, channels.pickup.index, settle_s)?;
            require_unsaturated(&drive, &pickup, channels, dwell.carrier_hz)?;
            if drive.value.norm() < LEAST_RATIO * drive.rest_rms {
                bail!(
                    "the carrier of {:.0} Hz does not survive the loop: {:.1e} of full scale reads back under {:.1e} of other signal; a sound layer resamples it away, or the path is aliased: use a raw device such as hw:…",
                    dwell.carrier_hz,
                    drive.value.norm(),
                    drive.rest_rms
                );
            }
            Ok(Response {
                frequency_hz: dwell.carrier_hz,
                ratio: pickup.value / drive.value,
            })
        })
        .collect()
}
