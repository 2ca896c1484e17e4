//! Noise of envelopes that a lock-in amplifier's low-pass took away.
//!
//! The noise of an envelope e at the rate f_s is even up to high frequencies, and a low-pass leaves it at low ones alone. The signal
//! itself, large and slow, would hide it; in its fourth difference
//!
//! ```text
//! Δ⁴e,  |H(f)|² = (2 sin πf/f_s)⁸
//! ```
//!
//! it is small, and the spectrum of the noise is that of Δ⁴e over |H|².

use std::f64::consts::PI;

use statistics::median;

/// Band in which a low-pass leaves the noise, and band in which it takes it away, Hz.
const LOW_HZ: [f64; 2] = [100.0, 200.0];
const HIGH_HZ: [f64; 2] = [500.0, 700.0];
/// Largest power of the noise in the high band of a filtered envelope, relative to that in the low band: a low-pass of order 4 leaves as
/// much at 0.35 ms, and the plate itself, at Q = 200, more of the noise in the pickup.
const FILTERED: f64 = 0.03;
/// Shortest time, s.
const SHORTEST_S: f64 = 0.4;

/// Returns the power of the noise at some 600 Hz relative to that at 150 Hz, if both envelopes at `rate_hz` were low-passed.
#[must_use]
pub fn filtered_envelopes(envelopes: [&[f64]; 2], rate_hz: f64) -> Option<f64> {
    let [drive, pickup] = envelopes.map(|envelope| fall(envelope, rate_hz));
    let largest = drive?.max(pickup?);
    (largest < FILTERED).then_some(largest)
}

/// Returns the power of the noise in the high band relative to that in the low one; `None` where too little is known.
fn fall(envelope: &[f64], rate_hz: f64) -> Option<f64> {
    let has_band = rate_hz > 2.2 * HIGH_HZ[1];
    let is_long = envelope.len() as f64 > SHORTEST_S * rate_hz;
    if !has_band || !is_long || !envelope.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mut differences = envelope.to_vec();
    for _ in 0..4 {
        differences = differences
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
    }
    let step_hz = rate_hz / differences.len() as f64;
    let powers = fourier::tone_powers(&differences);
    let noise = |[from_hz, to_hz]: [f64; 2]| {
        let lines = (from_hz / step_hz) as usize..(to_hz / step_hz) as usize;
        let lines = lines.filter_map(|line| {
            let answer = (2.0 * (PI * line as f64 * step_hz / rate_hz).sin()).powi(8);
            Some(powers.get(line)? / answer)
        });
        median(lines)
    };
    let (low, high) = (noise(LOW_HZ)?, noise(HIGH_HZ)?);
    (low > 0.0).then(|| high / low)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE_HZ: f64 = 6000.0;

    /// One second of an envelope of 24 V modulated at 6 Hz with noise of 1 mV, by a generator of Numerical Recipes, after `order` poles of
    /// `tau_s`.
    fn envelope(seed: u64, order: u32, tau_s: f64) -> Vec<f64> {
        let mut state = seed;
        let signal = |step: u32| {
            let time_s = f64::from(step) / RATE_HZ;
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let noise = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            24.0 * (1.0 + 0.95 * (TAU * 6.0 * time_s).sin()) + 3.5e-3 * noise
        };
        let mut values: Vec<f64> = (0..9000).map(signal).collect();
        let keep = if tau_s > 0.0 {
            (-1.0 / (RATE_HZ * tau_s)).exp()
        } else {
            0.0
        };
        for _ in 0..order {
            let mut level = values[0];
            for value in &mut values {
                level = keep * level + (1.0 - keep) * *value;
                *value = level;
            }
        }
        values[3000..].to_vec()
    }

    #[test]
    fn a_low_pass_shows_in_the_noise_of_both_envelopes() {
        let pair = |order, tau_s| [envelope(1, order, tau_s), envelope(2, order, tau_s)];
        let found = |[drive, pickup]: &[Vec<f64>; 2]| filtered_envelopes([drive, pickup], RATE_HZ);
        for tau_s in [5e-4, 1e-3, 3e-3] {
            assert!(found(&pair(4, tau_s)).is_some(), "{tau_s}");
        }
        for (order, tau_s) in [(0, 0.0), (4, 3e-5), (1, 1e-4)] {
            assert_eq!(found(&pair(order, tau_s)), None, "{order} {tau_s}");
        }
        assert_eq!(found(&[envelope(1, 4, 1e-3), envelope(2, 0, 0.0)]), None);
        // Without noise but that of numbers.
        let steady = vec![24.0; 6000];
        assert_eq!(filtered_envelopes([&steady, &steady], RATE_HZ), None);
        assert_eq!(filtered_envelopes([&steady[..100], &steady], RATE_HZ), None);
    }
}
