//! First pass over drive and pickup: their envelopes at about 2 kHz, the carrier, and the state of the channels.

use metrology::drive_modulation::{self, FoundModulation, ModulationError};
use std::f64::consts::TAU;

use num_complex::Complex64;
use plausibility::Extremes;

use crate::refusal::ImportRefusal;
use crate::sources::{Column, Sources};

/// Rate of the envelopes, Hz, and the most values of one: a recording longer than 17 minutes has a lower rate, of 1.2 kHz in half an
/// hour and 230 Hz in two hours and a half.
const FRAMES_HZ: f64 = 2000.0;
const MOST_VALUES: u64 = 1 << 21;
/// Samples of a stretch of which a spectrum is computed, and the number of stretches.
pub(crate) const SPECTRUM_SAMPLES: u64 = 1 << 16;
const SPECTRUM_STRETCHES: u64 = 12;
/// Lowest carrier, Hz.
const LOWEST_CARRIER_HZ: f64 = 1000.0;
/// Power of a carrier over the median power of the spectrum's bins.
const STANDS_OUT: f64 = 1e3;
/// Most values of an envelope that show its modulation: two minutes. Spectra of an hour take half a gigabyte.
const MODULATION_VALUES: usize = 1 << 18;
/// Share of the largest amplitude below which the drive counts as off.
const OFF_SHARE: f64 = 0.02;

/// Envelope of a channel.
#[derive(Debug, Clone)]
pub(crate) struct Envelope {
    /// Time of the first value, s.
    pub first_s: f64,
    /// Interval, s.
    pub step_s: f64,
    /// Frequency that the values refer to, Hz.
    pub reference_hz: f64,
    /// Peak envelope, sample units.
    pub values: Vec<Complex64>,
}

impl Envelope {
    /// Returns the time of a value, s.
    pub fn time_s(&self, index: usize) -> f64 {
        self.first_s + index as f64 * self.step_s
    }

    /// Returns the modulation of a drive's amplitude, in `volts_per_unit`, from the time at which it is on.
    ///
    /// # Errors
    /// The drive is off, or on too briefly.
    pub fn modulation(&self, volts_per_unit: f64) -> Result<FoundModulation, ModulationError> {
        let scale = volts_per_unit.abs();
        let start = self.loud().into_iter().position(|is_loud| is_loud);
        let driven = self.values.iter().skip(start.unwrap_or(0));
        let driven = driven.take(MODULATION_VALUES);
        let amplitude_v = driven.map(|value| scale * value.norm());
        let amplitude_v: Vec<f64> = amplitude_v.collect();
        let known = amplitude_v.iter().filter(|value| value.is_finite());
        let squares = known.clone().map(|value| value * value / 2.0).sum::<f64>();
        let rms_v = (squares / known.count().max(1) as f64).sqrt();
        let found = drive_modulation::require(&amplitude_v, self.step_s, rms_v)?;
        Ok(found.of_means(self.step_s))
    }

    /// Returns the indices of values from which on the envelope is lower than that.
    fn loud(&self) -> Vec<bool> {
        let largest = self
            .values
            .iter()
            .map(|value| value.norm())
            .filter(|norm| norm.is_finite())
            .fold(0.0, f64::max);
        self.values
            .iter()
            .map(|value| value.norm() > OFF_SHARE * largest)
            .collect()
    }
}

/// A channel after the first pass.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    /// Envelope.
    pub envelope: Envelope,
    /// Extremes.
    pub range: Extremes,
}

/// Returns the frequency of the strongest tone of a channel, Hz, to the spectrum's resolution; `None` if none stands out.
pub(crate) fn strongest_tone(
    sources: &mut Sources<'_>,
    column: &Column,
    rate_hz: f64,
) -> Result<Option<f64>, ImportRefusal> {
    let length = SPECTRUM_SAMPLES.min(column.len());
    let count = (column.len() / length).clamp(1, SPECTRUM_STRETCHES);
    let size = length as usize;
    let transform = fourier::forward(size);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let mut power = vec![0.0; output.len()];
    for stretch in 0..count {
        let start = if count == 1 {
            0
        } else {
            (column.len() - length) / (count - 1) * stretch
        };
        let mut values = Vec::new();
        sources.read(column, start..start + length, &mut values)?;
        let finite = values.iter().filter(|value| value.is_finite());
        let mean = finite.clone().sum::<f64>() / (finite.count().max(1)) as f64;
        let weighted = input.iter_mut().zip(&values).zip(fourier::hann(size));
        for ((x, value), weight) in weighted {
            *x = if value.is_finite() {
                weight * (value - mean)
            } else {
                0.0
            };
        }
        // The transform made the buffers, so they fit.
        if transform.process(&mut input, &mut output).is_ok() {
            for (sum, bin) in power.iter_mut().zip(&output) {
                *sum += bin.norm_sqr();
            }
        }
    }
    let resolution_hz = rate_hz / size as f64;
    let lowest = ((LOWEST_CARRIER_HZ / resolution_hz).ceil() as usize).clamp(1, power.len());
    let peak = (lowest..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]));
    let median = statistics::median(power[lowest..].iter().copied()).unwrap_or(0.0);
    let Some(peak) = peak.filter(|peak| power[*peak] > 0.0 && power[*peak] > STANDS_OUT * median)
    else {
        return Ok(None);
    };
    let bins = peak.saturating_sub(2)..(peak + 3).min(power.len());
    let total: f64 = power[bins.clone()].iter().sum();
    let centre = bins.map(|bin| bin as f64 * power[bin]).sum::<f64>() / total;
    Ok(Some(centre * resolution_hz))
}

/// Returns the number of samples in a value of an envelope.
fn samples_per_value(rate_hz: f64, samples: u64) -> u64 {
    let usual = (rate_hz / FRAMES_HZ).round().max(1.0) as u64;
    usual.max(samples.div_ceil(MOST_VALUES))
}

/// Reads a channel whole: its envelope about `reference_hz`, and its extremes.
pub(crate) fn channel(
    sources: &mut Sources<'_>,
    column: &Column,
    rate_hz: f64,
    reference_hz: f64,
) -> Result<Channel, ImportRefusal> {
    let group = samples_per_value(rate_hz, column.len());
    let mut range = Extremes::default();
    let mut values = Vec::new();
    let (mut sum, mut count) = (Complex64::ZERO, 0u64);
    let step_rad = TAU * reference_hz / rate_hz;
    let rotation = Complex64::cis(-step_rad);
    let mut phasor = Complex64::ONE;
    sources.for_each_block(column, |start, block| {
        // Begun anew in each block, so that rounding does not accumulate.
        let turns = (start as f64 * (reference_hz / rate_hz)).fract();
        phasor = Complex64::cis(-TAU * turns);
        for value in block {
            range.take(*value);
            sum += phasor * value;
            phasor *= rotation;
            count += 1;
            if count == group {
                values.push(2.0 * sum / group as f64);
                (sum, count) = (Complex64::ZERO, 0);
            }
        }
        Ok(())
    })?;
    Ok(Channel {
        envelope: Envelope {
            first_s: (group - 1) as f64 / 2.0 / rate_hz,
            step_s: group as f64 / rate_hz,
            reference_hz,
            values,
        },
        range,
    })
}

/// Frequency of a carrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CarrierFrequency {
    /// Frequency, Hz.
    pub hz: f64,
    /// Standard error, Hz.
    pub error_hz: f64,
    /// Difference between the frequencies of the parts in which it is farthest from its mean, Hz.
    pub range_hz: f64,
}

/// Measures the carrier's frequency from the rotation of an envelope, while the drive is on.
pub(crate) fn carrier(envelope: &Envelope) -> Option<CarrierFrequency> {
    let loud = envelope.loud();
    // The mean rotation between neighbours, then a line through the phases of each stretch.
    let turns: Complex64 = (1..envelope.values.len())
        .filter(|index| loud[*index] && loud[index - 1])
        .map(|index| envelope.values[index] * envelope.values[index - 1].conj())
        .filter(|turn| turn.is_finite())
        .sum();
    if turns.norm() == 0.0 {
        return None;
    }
    let mean_rad = turns.arg();
    let mut slopes: Vec<(f64, f64)> = Vec::new();
    let mut start = 0;
    while start < loud.len() {
        if !loud[start] {
            start += 1;
            continue;
        }
        let end = (start..loud.len())
            .find(|index| !loud[*index])
            .unwrap_or(loud.len());
        // Parts of a second at most, so that a carrier that moves shows.
        let longest = ((1.0 / envelope.step_s) as usize).max(8);
        let parts = (end - start).div_ceil(longest);
        for part in 0..parts {
            let from = start + (end - start) * part / parts;
            let to = start + (end - start) * (part + 1) / parts;
            slopes.extend(slope(&envelope.values[from..to], mean_rad));
        }
        start = end;
    }
    // The phase of a stretch of n values with equal errors has a slope with the variance ∝ n⁻³.
    let weights: f64 = slopes.iter().map(|(_, weight)| weight).sum();
    if weights.is_nan() || weights <= 0.0 {
        return None;
    }
    let mean = slopes
        .iter()
        .map(|(slope, weight)| slope * weight)
        .sum::<f64>()
        / weights;
    let to_hz = 1.0 / (TAU * envelope.step_s);
    let scatter = slopes
        .iter()
        .map(|(slope, weight)| weight * (slope - mean).powi(2))
        .sum::<f64>()
        / weights;
    let (low, high) = slopes.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(low, high), (slope, _)| (low.min(*slope), high.max(*slope)),
    );
    let count = slopes.len() as f64;
    let error = (scatter / count.max(2.0)).sqrt();
    Some(CarrierFrequency {
        hz: envelope.reference_hz + (mean_rad + mean) * to_hz,
        error_hz: (error * to_hz).max(1e-9 * envelope.reference_hz),
        range_hz: (high - low) * to_hz,
    })
}

/// Returns the slope of the phase beyond `mean_rad` per value, and its weight; `None` for short stretches.
fn slope(values: &[Complex64], mean_rad: f64) -> Option<(f64, f64)> {
    const LEAST: usize = 100;
    if values.len() < LEAST || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let mut phase = 0.0;
    let mut previous = values[0];
    let (mut sum, mut moment, mut weight, mut square, mut phases) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        if index > 0 {
            phase += (value * previous.conj() * Complex64::cis(-mean_rad)).arg();
        }
        previous = *value;
        let (w, x) = (value.norm_sqr(), index as f64);
        weight += w;
        sum += w * x;
        square += w * x * x;
        phases += w * phase;
        moment += w * x * phase;
    }
    let spread = square - sum * sum / weight;
    let slope = (moment - sum * phases / weight) / spread;
    slope
        .is_finite()
        .then_some((slope, spread / weight * values.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_of_any_length_has_a_bounded_number_of_values() {
        assert_eq!(samples_per_value(192e3, 192_000 * 1000), 96);
        for hours in [1, 3, 24] {
            let samples = 192_000 * 3600 * hours;
            assert!(samples / samples_per_value(192e3, samples) <= MOST_VALUES);
        }
    }

    #[test]
    fn two_minutes_of_a_long_drive_show_its_modulation() {
        let step_s = 0.5e-3;
        let value = |n: usize| {
            let modulation_hz = if n < MODULATION_VALUES { 6.0 } else { 7.0 };
            let t = n as f64 * step_s;
            Complex64::from(1.0 + 0.5 * (TAU * modulation_hz * t).sin())
        };
        let envelope = Envelope {
            first_s: 0.0,
            step_s,
            reference_hz: 35_000.0,
            values: (0..3 * MODULATION_VALUES).map(value).collect(),
        };
        let found = envelope.modulation(20.0).unwrap();
        assert!((found.hz - 6.0).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn the_carrier_is_found_to_a_millihertz_through_its_modulation() {
        let step_s = 0.5e-3;
        let envelope = Envelope {
            first_s: 0.0,
            step_s,
            reference_hz: 35_000.0,
            values: (0..6000)
                .map(|n| {
                    let t = f64::from(n) * step_s;
                    let amplitude = 1.0 + 0.95 * (TAU * 6.0 * t).sin();
                    let level = if n > 500 { 1.0 } else { 0.0 };
                    level * amplitude * Complex64::cis(TAU * 3.25 * t)
                })
                .collect(),
        };
        let found = carrier(&envelope).unwrap();
        assert!((found.hz - 35_003.25).abs() < 1e-3, "{found:?}");
        assert!(found.range_hz < 0.01, "{found:?}");
        let moving = Envelope {
            values: (0..6000)
                .map(|n| Complex64::cis(TAU * 2.0 * (f64::from(n) * step_s).powi(2)))
                .collect(),
            ..envelope
        };
        assert!(carrier(&moving).unwrap().range_hz > 5.0);
    }
}
