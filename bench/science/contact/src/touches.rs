//! Touches of the plate by a finger, from the normal force.
//!
//! A finger warms the plate from the moment it lands to the moment it has left, up to a tenth of a second after it last weighed 50 mN.
//! Touches counted at 50 mN are some per cent too short, and the plate's course, predicted from them, too steep.

use statistics::quantile;

use crate::plate_course::Touches;

/// Longest time between a finger's first or last touch and the force that counts as one, s.
const LONGEST_LANDING_S: f64 = 0.25;
/// Share of the forces without a finger that are smaller than the sensor's noise, and the factor from which on a force is a finger's:
/// 5.2 standard deviations of normal noise. A coarse sensor mostly reads 0, and its median has no noise.
const NOISE_SHARE: f64 = 0.99;
const NOISE_FACTOR: f64 = 2.0;
/// Smallest force of a finger, N, however little the sensor's noise.
const LIGHTEST_N: f64 = 1e-3;
/// Longest pauses within a touch, s: of a finger that presses, and of one that lands or leaves, of which single readings may be noise.
const PRESSING_PAUSE_S: f64 = 0.1;
const LANDING_PAUSE_S: f64 = 0.01;

/// Returns begin and end of each touch, s, from the normal force at some times. A touch holds a force of `off_n` or more, N, and lasts
/// while the force about it exceeds the sensor's noise. The plate does not count as free where the force was not measured, NaN.
#[must_use]
pub fn touches_s(times_s: &[f64], normal_n: &[f64], off_n: f64) -> Vec<(f64, f64)> {
    let forces = || times_s.iter().copied().zip(normal_n.iter().copied());
    let times_from = |least_n: f64| {
        let counted = forces().filter(move |(_, n)| n.is_nan() || n.abs() >= least_n);
        counted.map(|(time_s, _)| time_s)
    };
    let pressed_s = joined(times_from(off_n), PRESSING_PAUSE_S);
    let free = forces().filter(|(time_s, _)| is_free(&pressed_s, *time_s, LONGEST_LANDING_S));
    let mut free_n: Vec<f64> = free.map(|(_, n)| n.abs()).collect();
    free_n.sort_by(f64::total_cmp);
    let Some(noise_n) = quantile(&free_n, NOISE_SHARE) else {
        return pressed_s;
    };
    let least_n = (NOISE_FACTOR * noise_n).max(LIGHTEST_N).min(off_n);
    let felt_s = joined(times_from(least_n), LANDING_PAUSE_S);
    let around = |time_s: f64| {
        let felt = felt_s.iter();
        felt.copied()
            .find(|felt| (felt.0..=felt.1).contains(&time_s))
            .unwrap_or((time_s, time_s))
    };
    let mut touches: Vec<(f64, f64)> = Vec::new();
    for &(begin_s, end_s) in &pressed_s {
        let touch = (
            around(begin_s).0.max(begin_s - LONGEST_LANDING_S),
            around(end_s).1.min(end_s + LONGEST_LANDING_S),
        );
        match touches.last_mut() {
            Some(last) if touch.0 <= last.1 => last.1 = touch.1,
            _ => touches.push(touch),
        }
    }
    touches
}

/// Returns whether a time lies outside all touches by more than `margin_s`.
#[must_use]
pub fn is_free(touches_s: Touches<'_>, time_s: f64, margin_s: f64) -> bool {
    let next = touches_s.partition_point(|touch| touch.1 < time_s - margin_s);
    touches_s
        .get(next)
        .is_none_or(|touch| touch.0 > time_s + margin_s)
}

/// Joins times with shorter pauses than `pause_s` to intervals.
fn joined(times_s: impl Iterator<Item = f64>, pause_s: f64) -> Vec<(f64, f64)> {
    let mut intervals: Vec<(f64, f64)> = Vec::new();
    for time_s in times_s {
        match intervals.last_mut() {
            Some((_, end_s)) if time_s - *end_s < pause_s => *end_s = time_s,
            _ => intervals.push((time_s, time_s)),
        }
    }
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times_s() -> Vec<f64> {
        (0..6000).map(|step| f64::from(step) / 2000.0).collect()
    }

    fn touches_of(force_n: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let times_s = times_s();
        let normal_n: Vec<f64> = times_s.iter().copied().map(force_n).collect();
        touches_s(&times_s, &normal_n, 0.05)
    }

    /// A finger on the plate from 1 to 2 s, which lands at 0.5 N/s and leaves at 0.4 N/s.
    fn soft_n(time_s: f64) -> f64 {
        (0.5 * (time_s - 1.0))
            .min(0.4 * (2.0 - time_s))
            .clamp(0.0, 0.3)
    }

    /// Regression test: touches began and ended at 50 mN, and were up to a tenth of a second too short.
    #[test]
    fn a_touch_lasts_from_the_landing_to_the_last_force() {
        for (noise_n, error_s) in [(0.0, 3e-3), (2e-3, 0.03), (0.03, 0.13)] {
            let touches = touches_of(|time_s| soft_n(time_s) + noise_n * (1e4 * time_s).sin());
            let [(begin_s, end_s)] = touches[..] else {
                panic!("{noise_n}: {touches:?}")
            };
            assert!((begin_s - 1.0).abs() < error_s, "{noise_n}: {begin_s}");
            assert!((end_s - 2.0).abs() < error_s, "{noise_n}: {end_s}");
        }
    }

    /// A sensor that resolves 10 mN reads 0 most of the time, and 10 mN in single readings and in runs of them.
    #[test]
    fn steps_of_a_coarse_sensor_are_no_touch() {
        let noise_n = |time_s: f64| 3e-3 * (1e4 * time_s).sin() + 3e-3 * (47.0 * time_s).sin();
        let touches =
            touches_of(|time_s| ((soft_n(time_s) + noise_n(time_s)) / 0.01).round() * 0.01);
        let [(begin_s, end_s)] = touches[..] else {
            panic!("{touches:?}")
        };
        assert!((begin_s - 1.0).abs() < 0.06, "{begin_s}");
        assert!((end_s - 2.0).abs() < 0.06, "{end_s}");
    }

    /// A force that stays below a finger's, such as a zero that is off after the touch, prolongs it by a landing at most.
    #[test]
    fn a_zero_that_has_moved_is_no_endless_touch() {
        let touches = touches_of(|time_s| soft_n(time_s) + if time_s > 1.5 { 0.03 } else { 0.0 });
        let [(_, end_s)] = touches[..] else {
            panic!("{touches:?}")
        };
        assert!(end_s < 2.0 + LONGEST_LANDING_S, "{end_s}");
    }

    #[test]
    fn taps_of_one_finger_are_one_touch_if_it_stays_on_the_plate() {
        let taps_n = |time_s: f64, least_n: f64| match time_s {
            1.0..1.3 | 1.6..2.0 => 0.5,
            1.3..1.6 => least_n,
            _ => 0.0,
        };
        assert_eq!(touches_of(|time_s| taps_n(time_s, 0.02)).len(), 1);
        let touches = touches_of(|time_s| taps_n(time_s, 0.0));
        assert_eq!(touches.len(), 2, "{touches:?}");
        assert!(is_free(&touches, 1.45, 0.1) && !is_free(&touches, 1.45, 0.2));
        assert!(is_free(&touches, 0.5, 0.4) && !is_free(&touches, 1.1, 0.0));
        assert!(is_free(&touches, 2.5, 0.4) && is_free(&[], 1.0, 9.0));
    }

    #[test]
    fn an_unmeasured_force_is_a_touch_and_no_force_none() {
        assert_eq!(touches_of(|_| f64::NAN), [(0.0, 5999.0 / 2000.0)]);
        assert_eq!(touches_of(|_| 0.0), []);
        assert_eq!(touches_s(&[], &[], 0.05), []);
    }
}
