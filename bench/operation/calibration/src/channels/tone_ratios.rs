//! Ratios of the inputs to the drive's input, tone by tone.

use std::f64::consts::TAU;

use metrology::channel_fit::{RatioReading, find_slip};
use metrology::spectrum::NoiseDensity;
use num_complex::Complex64;

use super::channels_setup::{ChannelsSetup, DWELL_S, SETTLE_S};
use super::fault::ChannelsFault;

/// Frequency of each tone, Hz, in order of time, with amplitude and phase of each input, sample units.
pub(super) type Tones = Vec<(f64, Vec<Complex64>)>;

/// Returns the standard deviation of each quadrature of a tone read through a Hann window, sample units.
pub(super) fn quadrature(noise: &NoiseDensity, dwell_s: f64) -> f64 {
    noise.value * (1.5 / (dwell_s - SETTLE_S)).sqrt()
}

/// Returns the ratio of `input` to `drive` at each tone, in order of time, minus `leaked`.
pub(super) fn ratios(
    tones: &Tones,
    [input, drive]: [usize; 2],
    noise: &[NoiseDensity],
    leaked: Option<&[RatioReading]>,
) -> Vec<RatioReading> {
    tones
        .iter()
        .enumerate()
        .map(|(i, (frequency_hz, values))| {
            let ratio = values[input] / values[drive];
            let sigma = |channel: usize| quadrature(&noise[channel], DWELL_S);
            let mut absolute = sigma(input) / values[drive].norm();
            absolute = absolute.hypot(ratio.norm() * sigma(drive) / values[drive].norm());
            let leak = leaked.and_then(|leaked| leaked.get(i));
            if let Some(leak) = leak {
                absolute = absolute.hypot(leak.sigma * leak.ratio.norm());
            }
            let ratio = ratio - leak.map_or(Complex64::ZERO, |leak| leak.ratio);
            RatioReading {
                frequency_hz: *frequency_hz,
                ratio,
                sigma: absolute / ratio.norm(),
            }
        })
        .collect()
}

/// Rejects a channel that slipped during the measurement; if all other inputs slip equally, the drive's input slipped.
pub(super) fn require_kept_places(
    setup: &ChannelsSetup,
    tones: &Tones,
    noise: &[NoiseDensity],
) -> Result<(), ChannelsFault> {
    let (drive, rate_hz) = (setup.drive(), setup.rate_hz());
    let slips: Vec<(u16, i32)> = (0..setup.inputs())
        .filter(|&input| input != drive)
        .filter_map(|input| {
            let ratios = ratios(tones, [input, drive].map(usize::from), noise, None);
            let slip = find_slip(&ratios, setup.carrier_hz, rate_hz)?;
            Some((input, slip.samples))
        })
        .collect();
    let Some(&(first, samples)) = slips.first() else {
        return Ok(());
    };
    let other_count = usize::from(setup.inputs()) - 1;
    let is_common =
        other_count > 1 && slips.len() == other_count && slips.iter().all(|s| s.1 == samples);
    let (input, samples) = if is_common {
        (drive, -samples)
    } else {
        (first, samples)
    };
    Err(ChannelsFault::Slipped {
        input,
        samples,
        phase_rad: -TAU * setup.carrier_hz / rate_hz * f64::from(samples),
    })
}
