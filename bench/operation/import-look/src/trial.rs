//! Trial of guessed rules on the data that they were guessed from.
//!
//! As an import does: positions are filtered at 50 Hz before their derivative, forces and speeds at 20 Hz.

use std::f64::consts::TAU;

use crate::excerpt::FineCourse;

/// −3 dB of the filters, Hz.
const RULE_HZ: f64 = 20.0;
const DERIVATIVE_HZ: f64 = 50.0;

/// Returns the velocity of positions in m, m/s.
pub(crate) fn velocity(position: &FineCourse, metres: f64) -> FineCourse {
    let mut values: Vec<f64> = known(position).map(|value| value * metres).collect();
    low_pass(&mut values, position.interval_s, DERIVATIVE_HZ);
    let last = values.len().saturating_sub(1);
    let slope = |n: usize| {
        let (before, after) = (n.saturating_sub(1), (n + 1).min(last));
        (values[after] - values[before]) / ((after - before).max(1) as f64 * position.interval_s)
    };
    FineCourse {
        interval_s: position.interval_s,
        values: (0..values.len()).map(slope).collect(),
    }
}

/// Returns the longest time for which the filtered values meet a condition without a change of their class, s.
pub(crate) fn longest_s<C: PartialEq>(fine: &FineCourse, class: impl Fn(f64) -> Option<C>) -> f64 {
    let (mut longest, mut count, mut last) = (0_usize, 0_usize, None);
    for value in filtered(fine) {
        let found = class(value);
        count = match (&found, found == last) {
            (None, _) => 0,
            (Some(_), true) => count + 1,
            (Some(_), false) => 1,
        };
        longest = longest.max(count);
        last = found;
    }
    longest.saturating_sub(1) as f64 * fine.interval_s
}

/// Returns the values as a rule takes them.
pub(crate) fn filtered(fine: &FineCourse) -> impl Iterator<Item = f64> + use<> {
    let mut values: Vec<f64> = known(fine).collect();
    low_pass(&mut values, fine.interval_s, RULE_HZ);
    values.into_iter()
}

/// Returns the values; in place of lost ones the last one before.
fn known(fine: &FineCourse) -> impl Iterator<Item = f64> {
    let first = fine.values.iter().copied().find(|value| value.is_finite());
    let mut last = first.unwrap_or_default();
    fine.values.iter().map(move |value| {
        if value.is_finite() {
            last = *value;
        }
        last
    })
}

/// Filters values by two first-order sections forwards and two backwards.
fn low_pass(values: &mut [f64], interval_s: f64, frequency_hz: f64) {
    // Four sections have the gain (1 + (f/f0)²)⁻², which is 2^(−1/2) at f = f0 √(2^(1/4) − 1).
    let constant_s = (2_f64.powf(0.25) - 1.0).sqrt() / (TAU * frequency_hz);
    let share = -f64::exp_m1(-interval_s / constant_s);
    for _ in 0..2 {
        section(values.iter_mut(), share);
        section(values.iter_mut().rev(), share);
    }
}

/// Moves each value by a share of its distance from the one before, from the first value on.
fn section<'a>(values: impl Iterator<Item = &'a mut f64>, share: f64) {
    let mut last: Option<f64> = None;
    for value in values {
        if let Some(filtered) = last {
            *value = filtered + (*value - filtered) * share;
        }
        last = Some(*value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_has_its_speed_for_its_time() {
        // 2 s of rest, 1.5 s at 20 mm/s, rest; 400 Hz, in mm.
        let values = (0..2_000).map(|n| 20.0 * (f64::from(n) / 400.0 - 2.0).clamp(0.0, 1.5));
        let position = FineCourse {
            interval_s: 1.0 / 400.0,
            values: values.collect(),
        };
        let speed = velocity(&position, 1e-3);
        let within = |from: f64, to: f64| {
            longest_s(&speed, |v| {
                (from..=to).contains(&v.abs()).then_some(v > 0.0)
            })
        };
        assert!(
            (within(0.014, 0.026) - 1.5).abs() < 0.05,
            "{}",
            within(0.014, 0.026)
        );
        assert!(within(0.05, 0.1) < 0.02);
        let rest = longest_s(&speed, |v| (v.abs() < 1e-3).then_some(()));
        assert!((rest - 2.0).abs() < 0.1, "{rest}");
    }
}
