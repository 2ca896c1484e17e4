//! Series of samples, their filter, and the velocity of positions.

use std::f64::consts::TAU;

/// Samples of one quantity, in SI units, at their times.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// Times of the samples, s, increasing.
    pub time_s: &'a [f64],
    /// Values, one for each time: N, m/s, or m in [`velocity`]; NaN where a sample is lost.
    pub values: &'a [f64],
}

/// Frequency of −3 dB of the filter under a rule, Hz.
const RULE_HZ: f64 = 20.0;
/// Frequency of −3 dB of the filter under a derivative, Hz: with the rule's filter after it, steps of an encoder are smoothed, and
/// the flanks are the rule's.
const DERIVATIVE_HZ: f64 = 50.0;
/// Shortest gap, s; shorter intervals are jitter.
const GAP_S: f64 = 0.05;
/// Gap in a slow series, in sampling intervals.
const GAP_INTERVALS: f64 = 3.0;

/// Samples of a series without gaps, filtered.
#[derive(Debug)]
pub(crate) struct Stretch {
    pub time_s: Vec<f64>,
    pub values: Vec<f64>,
}

impl Series<'_> {
    /// Returns the filtered stretches between gaps.
    pub(crate) fn filtered(&self) -> Vec<Stretch> {
        self.stretches(RULE_HZ)
    }

    fn stretches(&self, low_pass_hz: f64) -> Vec<Stretch> {
        let longest_s = self.longest_interval_s();
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut last_s = f64::NEG_INFINITY;
        for (&time_s, &value) in self.time_s.iter().zip(self.values) {
            if !(value.is_finite() && time_s.is_finite() && time_s > last_s) {
                continue;
            }
            if time_s - last_s > longest_s {
                stretches.push(Stretch {
                    time_s: Vec::new(),
                    values: Vec::new(),
                });
            }
            if let Some(stretch) = stretches.last_mut() {
                stretch.time_s.push(time_s);
                stretch.values.push(value);
            }
            last_s = time_s;
        }
        for stretch in &mut stretches {
            remove_strays(&mut stretch.values);
            low_pass(&stretch.time_s, &mut stretch.values, low_pass_hz);
        }
        stretches
    }

    /// Returns the longest interval between two samples that is not a gap, s.
    fn longest_interval_s(&self) -> f64 {
        let intervals = self.time_s.windows(2).map(|pair| pair[1] - pair[0]);
        let typical = statistics::median(intervals.filter(|interval| *interval > 0.0));
        typical.map_or(GAP_S, |typical| GAP_S.max(GAP_INTERVALS * typical))
    }
}

/// Returns the velocity of positions in m/s, filtered at 50 Hz; NaN where a sample is lost or stands alone between gaps.
#[must_use]
pub fn velocity(position: &Series<'_>) -> Vec<f64> {
    let mut velocities = vec![f64::NAN; position.time_s.len()];
    let mut index = 0;
    for stretch in position.stretches(DERIVATIVE_HZ) {
        let n = stretch.time_s.len();
        for i in 0..n {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(n - 1));
            let interval_s = stretch.time_s[after] - stretch.time_s[before];
            while position.time_s[index] != stretch.time_s[i] || !position.values[index].is_finite()
            {
                index += 1;
            }
            if interval_s > 0.0 {
                velocities[index] = (stretch.values[after] - stretch.values[before]) / interval_s;
            }
            index += 1;
        }
    }
    velocities
}

/// Replaces each value by the median of itself and its neighbours.
fn remove_strays(values: &mut [f64]) {
    let mut before = values.first().copied().unwrap_or_default();
    for i in 1..values.len().saturating_sub(1) {
        let (value, after) = (values[i], values[i + 1]);
        values[i] = value.clamp(before.min(after), before.max(after));
        before = value;
    }
    // The ends have one neighbour: a stray there is beyond the two values next to it (Tukey 1977, end values).
    if let [first, second, third, ..] = *values {
        let line = 3.0 * second - 2.0 * third;
        values[0] = first.clamp(second.min(line), second.max(line));
    }
    if let [.., third, second, first] = *values {
        let line = 3.0 * second - 2.0 * third;
        let end = values.len() - 1;
        values[end] = first.clamp(second.min(line), second.max(line));
    }
}

/// Filters values at any times by two first-order sections forwards and two backwards, −3 dB at `frequency_hz`.
fn low_pass(time_s: &[f64], values: &mut [f64], frequency_hz: f64) {
    // Four sections have the gain (1 + (f/f0)²)⁻², which is 2^(−1/2) at f = f0 √(2^(1/4) − 1).
    let constant_s = (2_f64.powf(0.25) - 1.0).sqrt() / (TAU * frequency_hz);
    for _ in 0..2 {
        section(time_s.iter().copied(), values.iter_mut(), constant_s);
        section(
            time_s.iter().rev().map(|t| -t),
            values.iter_mut().rev(),
            constant_s,
        );
    }
}

/// Filters values by dy/dt = (x − y)/`constant_s`, from the first value on.
fn section<'a>(
    times_s: impl Iterator<Item = f64>,
    values: impl Iterator<Item = &'a mut f64>,
    constant_s: f64,
) {
    let mut last: Option<(f64, f64)> = None;
    for (time_s, value) in times_s.zip(values) {
        if let Some((last_s, filtered)) = last {
            *value = filtered + (*value - filtered) * -f64::exp_m1(-(time_s - last_s) / constant_s);
        }
        last = Some((time_s, *value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(n: usize, rate_hz: f64) -> Vec<f64> {
        (0..n).map(|i| i as f64 / rate_hz).collect()
    }

    #[test]
    fn the_filter_has_its_frequency_and_no_delay() {
        let time_s = times(20_000, 10e3);
        let wave: Vec<f64> = time_s.iter().map(|t| (TAU * 20.0 * t).sin()).collect();
        let stretches = Series {
            time_s: &time_s,
            values: &wave,
        }
        .filtered();
        let values = &stretches[0].values;
        let (mut real, mut imaginary) = (0.0, 0.0);
        for i in 5_000..15_000 {
            real += 2e-4 * values[i] * wave[i];
            imaginary += 2e-4 * values[i] * (TAU * 20.0 * time_s[i]).cos();
        }
        assert!((real - 0.5_f64.sqrt()).abs() < 0.01, "{real}");
        assert!(imaginary.abs() < 0.01, "{imaginary}");
    }

    #[test]
    fn a_stray_sample_is_removed_at_any_rate_and_place() {
        for place in [0, 1, 57, 98, 99] {
            let time_s = times(100, 50.0);
            let mut values = vec![0.01; 100];
            values[place] = 40.0;
            let stretches = Series {
                time_s: &time_s,
                values: &values,
            }
            .filtered();
            assert!(
                stretches[0].values.iter().all(|v| (v - 0.01).abs() < 1e-12),
                "{place}"
            );
        }
    }

    #[test]
    fn a_step_keeps_its_time_and_does_not_overshoot() {
        let time_s = times(4_000, 2e3);
        let values: Vec<f64> = time_s.iter().map(|t| f64::from(*t >= 1.0)).collect();
        let filtered = &Series {
            time_s: &time_s,
            values: &values,
        }
        .filtered()[0];
        assert!(
            filtered
                .values
                .iter()
                .all(|v| (-1e-9..=1.0 + 1e-9).contains(v))
        );
        let crossing =
            |level: f64| filtered.time_s[filtered.values.iter().position(|v| *v > level).unwrap()];
        assert!((crossing(0.5) - 1.0).abs() < 1e-3, "{}", crossing(0.5));
        assert!(crossing(0.9) - crossing(0.1) < 0.03);
    }

    #[test]
    fn gaps_and_lost_samples_part_a_series() {
        let mut time_s = times(1_000, 1e3);
        time_s[500..].iter_mut().for_each(|t| *t += 0.2);
        let mut values = vec![1.0; 1_000];
        values[100..110].fill(f64::NAN);
        values[700..800].fill(f64::NAN);
        let lengths: Vec<usize> = Series {
            time_s: &time_s,
            values: &values,
        }
        .filtered()
        .iter()
        .map(|stretch| stretch.values.len())
        .collect();
        assert_eq!(lengths, [490, 200, 200]);
        assert!(
            Series {
                time_s: &[],
                values: &[]
            }
            .filtered()
            .is_empty()
        );
    }

    #[test]
    fn steps_of_an_encoder_are_a_steady_velocity() {
        let time_s = times(20_000, 10e3);
        let position: Vec<f64> = time_s
            .iter()
            .map(|t| (0.05 * t / 1e-4).floor() * 1e-4)
            .collect();
        let series = Series {
            time_s: &time_s,
            values: &position,
        };
        let velocities = velocity(&series);
        assert_eq!(velocities.len(), time_s.len());
        let filtered = Series {
            time_s: &time_s,
            values: &velocities,
        }
        .filtered();
        let middle = &filtered[0].values[2_000..18_000];
        assert!(middle.iter().all(|v| (v - 0.05).abs() < 1e-3));
    }

    #[test]
    fn velocity_is_unknown_where_the_position_is() {
        let time_s = times(300, 1e3);
        let mut position: Vec<f64> = time_s.iter().map(|t| 0.03 * t).collect();
        position[100..110].fill(f64::NAN);
        let velocities = velocity(&Series {
            time_s: &time_s,
            values: &position,
        });
        assert!(velocities[100..110].iter().all(|v| v.is_nan()));
        assert!((velocities[50] - 0.03).abs() < 1e-4 && (velocities[200] - 0.03).abs() < 1e-4);
    }
}
