//! Touches of the plate by a finger, from the normal force.
//!
//! A finger warms the plate from the moment it lands, some 10 ms before it weighs 50 mN, to the moment it has left, up to a tenth of a
//! second after. Touches counted at 50 mN are some per cent too short, and the plate's course, predicted from them, too steep.

use statistics::median;

use crate::plate_course::Touches;

/// Longest time between a finger's first or last touch and the force that counts as one, s.
const LONGEST_LANDING_S: f64 = 0.25;
/// Force relative to the median of the forces without a finger that is a finger's: five standard deviations of normal noise, of which
/// the median size is 0.6745.
const NOISE_FACTOR: f64 = 5.0 / 0.6745;
/// Smallest force of a finger, N, however little the sensor's noise.
const LIGHTEST_N: f64 = 1e-3;
/// Shorter pauses between forces belong to a touch, s.
const SHORTEST_PAUSE_S: f64 = 0.1;

/// Returns begin and end of each touch, s, from the normal force at some times. A touch holds a force of `off_n` or more, N, and lasts
/// while the force about it exceeds the sensor's noise. The plate does not count as free where the force was not measured, NaN.
#[must_use]
pub fn touches_s(times_s: &[f64], normal_n: &[f64], off_n: f64) -> Vec<(f64, f64)> {
    let forces = || times_s.iter().copied().zip(normal_n.iter().copied());
    let times_from = |least_n: f64| {
        let counted = forces().filter(move |(_, n)| n.is_nan() || n.abs() >= least_n);
        counted.map(|(time_s, _)| time_s)
    };
    let pressed_s = joined(times_from(off_n));
    let free_n = forces()
        .filter(|(time_s, _)| is_free(&pressed_s, *time_s, LONGEST_LANDING_S))
        .map(|(_, n)| n.abs());
    let Some(noise_n) = median(free_n) else {
        return pressed_s;
    };
    let felt_s = joined(times_from(
        (NOISE_FACTOR * noise_n).max(LIGHTEST_N).min(off_n),
    ));
    let mut touches: Vec<(f64, f64)> = Vec::new();
    for &(begin_s, end_s) in &pressed_s {
        let around = felt_s
            .iter()
            .find(|felt| felt.0 <= begin_s && end_s <= felt.1);
        let (felt_begin_s, felt_end_s) = *around.unwrap_or(&(begin_s, end_s));
        let touch = (
            felt_begin_s.max(begin_s - LONGEST_LANDING_S),
            felt_end_s.min(end_s + LONGEST_LANDING_S),
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

/// Joins times without longer pauses than those within a touch to intervals.
fn joined(times_s: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let mut intervals: Vec<(f64, f64)> = Vec::new();
    for time_s in times_s {
        match intervals.last_mut() {
            Some((_, end_s)) if time_s - *end_s < SHORTEST_PAUSE_S => *end_s = time_s,
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
