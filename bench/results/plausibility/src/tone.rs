//! Strongest tone of a channel without its carrier.

use statistics::significant;

use crate::implausible::Implausible;

/// Fewest samples of a spectrum.
const FEWEST: usize = 1024;
/// Smallest distance of a tone from the stated carrier, relative.
const APART: f64 = 1e-3;
/// Ratio of the strongest line's power to the median of all from which it is a tone.
const PROMINENT: f64 = 1e3;
/// Share of a channel's power about its strongest line from which it is a carrier, and the width of that range, relative.
const CARRIER_SHARE: f64 = 0.25;
const CARRIER_WIDTH: f64 = 5e-3;

/// Returns the finding of samples of a channel in which the stated carrier is missing: a dead channel, or another carrier.
#[must_use]
pub fn without_carrier(
    name: &str,
    samples: &[f64],
    rate_hz: f64,
    stated_hz: f64,
) -> Option<Implausible> {
    let first = *samples.first()?;
    if samples.len() < FEWEST {
        return None;
    }
    if samples
        .iter()
        .all(|sample| *sample == first || sample.is_nan())
    {
        let value = significant(first);
        return Some(Implausible::DeadChannel {
            channel: name.to_owned(),
            value,
        });
    }
    let length = 1 << samples.len().ilog2();
    let n = length as f64;
    let mean = samples[..length].iter().sum::<f64>() / n;
    let varying: Vec<f64> = samples[..length]
        .iter()
        .map(|sample| sample - mean)
        .collect();
    let powers = fourier::tone_powers(&varying);
    let middle = statistics::median(powers.iter().copied())?;
    let (line, power) = powers
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))?;
    let found_hz = line as f64 / n * rate_hz;
    let is_other = (found_hz / stated_hz - 1.0).abs() > APART;
    let is_near = |line: usize| (line as f64 / n * rate_hz / found_hz - 1.0).abs() < CARRIER_WIDTH;
    let near = powers.iter().enumerate().filter(|(line, _)| is_near(*line));
    let near_power: f64 = near.map(|(_, power)| power).sum();
    let is_carrier = near_power > CARRIER_SHARE * powers.iter().sum::<f64>();
    (*power > PROMINENT * middle && is_carrier && is_other).then_some(Implausible::OtherCarrier {
        found_hz,
        stated_hz,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_carrier_and_a_dead_channel_are_named() {
        let tone = |hz: f64| -> Vec<f64> {
            let sample = |index: u32| (std::f64::consts::TAU * hz * f64::from(index) / 96e3).sin();
            (0..8192).map(sample).collect()
        };
        let found = without_carrier("drive", &tone(25_000.0), 96e3, 35_000.0);
        let Some(Implausible::OtherCarrier { found_hz, .. }) = found else {
            panic!("{found:?}");
        };
        assert!((found_hz - 25_000.0).abs() < 12.0, "{found_hz}");
        assert_eq!(
            without_carrier("drive", &tone(35_000.0), 96e3, 35_000.0),
            None
        );
        let dead = without_carrier("pickup", &[0.25; 8192], 96e3, 35_000.0).unwrap();
        assert!(
            dead.to_string().contains("pickup") && dead.to_string().contains("dead"),
            "{dead}"
        );
        assert_eq!(without_carrier("drive", &[], 96e3, 35_000.0), None);
    }
}
