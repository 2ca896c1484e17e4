//! Carriers: their frequency, and their envelope with its modulation.

use std::f64::consts::TAU;

use metrology::spectrum::Spectrum;
use num_complex::Complex64;

use crate::periodicity::{Periodicity, periodicity};

/// A carrier in a channel. Without a known rate, frequencies are in cycles a sample and times in samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Carrier {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the crests of the modulation, peak, in units of the channel.
    pub amplitude: f64,
    /// Modulation of the envelope, if it is modulated.
    pub modulation: Option<Periodicity>,
    /// Spread of the mean amplitude over the periods of the modulation, relative to its median.
    pub unsteadiness: f64,
    /// Amplitude of the second and third harmonic, relative to the carrier's; `None` above half the rate.
    pub distortion: Option<f64>,
    /// Share of values at the channel's extremes.
    pub clipped_share: f64,
}

/// Carriers of plates for surface haptics, Hz.
pub(crate) const PLATES_HZ: std::ops::RangeInclusive<f64> = 20e3..=100e3;
/// Lowest frequency of a carrier, Hz, and in cycles a sample where the rate is unknown.
const LOWEST_HZ: f64 = 1_000.0;
const LOWEST_PER_SAMPLE: f64 = 0.01;
/// Least share of a carrier's power in that of its channel.
const LEAST_SHARE: f64 = 0.5;
/// Length of a segment of the spectrum, values.
const SEGMENT: f64 = 16_384.0;
/// Fewest values in which a carrier is sought.
const FEWEST: usize = 256;
/// Most values of the spectrum.
const MOST_IN_SPECTRUM: usize = 1 << 19;
/// Most values of an envelope.
const MOST_OF_ENVELOPE: usize = 16_384;
/// Cycles of the carrier in half the window of the demodulation.
const CYCLES: f64 = 4.0;
/// Share of values at an extreme from which on a channel counts as clipped.
pub(crate) const CLIPPED: f64 = 0.005;

/// Finds the carrier of a stretch, sampled at `rate_hz` if that is known.
pub(crate) fn carrier(values: &[f64], rate_hz: Option<f64>) -> Option<Carrier> {
    if values.len() < FEWEST {
        return None;
    }
    let rate = rate_hz.unwrap_or(1.0);
    let lowest = match rate_hz {
        Some(_) => LOWEST_HZ,
        None => LOWEST_PER_SAMPLE,
    };
    let centred = centred(values);
    let power = centred.iter().map(|x| x * x).sum::<f64>() / centred.len() as f64;
    let start = (centred.len() - centred.len().min(MOST_IN_SPECTRUM)) / 2;
    let part = &centred[start..start + centred.len().min(MOST_IN_SPECTRUM)];
    let samples: Vec<f32> = part.iter().map(|x| (x / power.sqrt()) as f32).collect();
    let segment = SEGMENT.min(samples.len() as f64 / 4.0);
    let spectrum = Spectrum::read(&samples, 1, 0, rate, rate / segment).ok()?;
    let peaks = spectrum.peaks();
    let strongest = peaks.iter().find(|peak| peak.frequency_hz >= lowest)?;
    let mut cycles_per_sample = strongest.frequency_hz / rate;
    let hop = hop(centred.len(), cycles_per_sample);
    let mut envelope = demodulated(&centred, cycles_per_sample, hop);
    // The phase's advance from block to block is the rest of the frequency.
    let advance: Complex64 = envelope
        .windows(2)
        .map(|pair| pair[1] * pair[0].conj())
        .sum();
    cycles_per_sample += advance.arg() / (TAU * hop as f64);
    envelope = demodulated(&centred, cycles_per_sample, hop);
    let mean_square = envelope.iter().map(Complex64::norm_sqr).sum::<f64>() / envelope.len() as f64;
    if 0.5 * mean_square < LEAST_SHARE * power {
        return None;
    }
    let amplitudes: Vec<f64> = envelope.iter().map(|x| x.norm()).collect();
    let modulation = periodicity(&amplitudes, hop as f64 / rate);
    let period = modulation.map_or(0.05 * rate, |sinusoid| rate / sinusoid.frequency_hz);
    let harmonics = [2.0, 3.0].map(|n| {
        let cycles = n * cycles_per_sample;
        (cycles < 0.45).then(|| mean_amplitude(&demodulated(&centred, cycles, hop)))
    });
    let distortion = harmonics[0]
        .map(|second| second.hypot(harmonics[1].unwrap_or_default()) / mean_amplitude(&envelope));
    let mut sorted = amplitudes.clone();
    sorted.sort_by(f64::total_cmp);
    Some(Carrier {
        frequency_hz: cycles_per_sample * rate,
        amplitude: statistics::quantile(&sorted, 0.99).unwrap_or_default(),
        modulation,
        unsteadiness: unsteadiness(&amplitudes, period / hop as f64),
        distortion,
        clipped_share: clipped_share(values),
    })
}

/// Returns the values less their mean; 0 where a value is lost.
fn centred(values: &[f64]) -> Vec<f64> {
    let finite = values.iter().filter(|x| x.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    let mean = sum / f64::max(count, 1.0);
    values
        .iter()
        .map(|x| if x.is_finite() { x - mean } else { 0.0 })
        .collect()
}

fn hop(length: usize, cycles_per_sample: f64) -> usize {
    let cycles = (CYCLES / cycles_per_sample).ceil() as usize;
    cycles.max(length / MOST_OF_ENVELOPE).clamp(1, length / 4)
}

/// Returns the complex envelope at each hop: means of 2 x exp(−iωt) under Hann windows of two hops.
fn demodulated(centred: &[f64], cycles_per_sample: f64, hop: usize) -> Vec<Complex64> {
    let omega = TAU * cycles_per_sample;
    let window: Vec<f64> = (0..2 * hop)
        .map(|n| (0.5 - 0.5 * (TAU * (n as f64 + 0.5) / (2 * hop) as f64).cos()) / hop as f64)
        .collect();
    let step = Complex64::from_polar(1.0, -omega);
    let starts = (0..=centred.len() - 2 * hop).step_by(hop);
    starts
        .map(|start| {
            let mut phasor = Complex64::from_polar(2.0, -omega * start as f64);
            let mut sum = Complex64::ZERO;
            for (x, w) in centred[start..start + 2 * hop].iter().zip(&window) {
                sum += phasor * (x * w);
                phasor *= step;
            }
            sum
        })
        .collect()
}

fn mean_amplitude(envelope: &[Complex64]) -> f64 {
    envelope.iter().map(|x| x.norm()).sum::<f64>() / envelope.len().max(1) as f64
}

/// Returns the spread of the means over periods, 10 to 90 %, relative to their median.
fn unsteadiness(amplitudes: &[f64], period: f64) -> f64 {
    let count = (amplitudes.len() as f64 / period) as usize;
    let mut means: Vec<f64> = (0..count)
        .map(|n| {
            let from = (n as f64 * period) as usize;
            let to = (((n + 1) as f64 * period) as usize).clamp(from + 1, amplitudes.len());
            amplitudes[from..to].iter().sum::<f64>() / (to - from) as f64
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let quantile = |share| statistics::quantile(&means, share).unwrap_or_default();
    match quantile(0.5) {
        median if median > 0.0 => (quantile(0.9) - quantile(0.1)) / median,
        _ => 0.0,
    }
}

/// Returns the share of values equal to the least or the greatest one.
fn clipped_share(values: &[f64]) -> f64 {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let extreme = values
        .iter()
        .filter(|x| **x == least || **x == greatest)
        .count();
    extreme as f64 / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn modulated(rate_hz: f64, seconds: f64, carrier_hz: f64, delay_s: f64) -> Vec<f64> {
        (0..(seconds * rate_hz) as usize)
            .map(|n| {
                let t = n as f64 / rate_hz;
                let envelope = 1.0 + 0.95 * (TAU * 6.0 * (t - delay_s)).sin();
                0.3 + 2.0 * envelope * (TAU * carrier_hz * t).cos()
                    + 0.01 * ((n * 7919) % 1000) as f64 / 1000.0
            })
            .collect()
    }

    #[test]
    fn carrier_and_modulation_are_found() {
        for (rate_hz, carrier_hz) in [(192e3, 35_012.3), (156_250.0, 22_000.0), (1e6, 61_803.4)] {
            let found = carrier(&modulated(rate_hz, 1.2, carrier_hz, 0.0), Some(rate_hz)).unwrap();
            assert!((found.frequency_hz - carrier_hz).abs() < 0.2, "{found:?}");
            let modulation = found.modulation.unwrap();
            assert!((modulation.frequency_hz - 6.0).abs() < 0.1, "{found:?}");
            assert!((modulation.index - 0.95).abs() < 0.02, "{found:?}");
            assert!((found.amplitude - 3.9).abs() < 0.1, "{found:?}");
            assert!(found.unsteadiness < 0.1, "{found:?}");
        }
    }

    #[test]
    fn a_carrier_is_found_without_a_rate() {
        let found = carrier(&modulated(200e3, 1.0, 35_000.0, 0.0), None).unwrap();
        assert!((found.frequency_hz - 0.175).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn a_delay_of_the_envelope_is_its_phase() {
        let [early, late] = [0.0, 1e-3].map(|delay_s| {
            let found = carrier(&modulated(192e3, 1.5, 35e3, delay_s), Some(192e3)).unwrap();
            found.modulation.unwrap()
        });
        assert!(
            (late.delay_s(&early).unwrap() - 1e-3).abs() < 5e-5,
            "{early:?} {late:?}"
        );
    }

    #[test]
    fn hum_noise_and_short_stretches_have_no_carrier() {
        let hum: Vec<f64> = (0..20_000)
            .map(|n| (TAU * 50.0 * f64::from(n) / 10e3).sin())
            .collect();
        assert_eq!(carrier(&hum, Some(10e3)), None);
        let noise: Vec<f64> = (0..20_000_u64)
            .map(|n| ((n * n * 7919) % 1009) as f64)
            .collect();
        assert_eq!(carrier(&noise, Some(10e3)), None);
        assert_eq!(carrier(&[1.0; 20], Some(10e3)), None);
        assert_eq!(carrier(&[1.0; 2_000], Some(10e3)), None);
    }
}
