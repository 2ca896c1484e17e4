//! Tares: the readings of the force sensor without a load.

use protocols::Direction;

use crate::series::Samples;

/// Force below which a plate counts as unloaded while its tare is found, N.
pub(crate) const REST_N: f64 = 0.05;
/// Length of a window of quiet, s.
const WINDOW_S: f64 = 0.2;
/// Time to leave out at both ends of a stretch without contact, s.
const MARGIN_S: f64 = 0.02;

/// Reading without a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tare {
    /// Reading, N.
    pub newtons: f64,
    /// Standard error, N.
    pub error: f64,
}

/// Estimates the tare of the normal force before anything is known of the contact: of the lowest and the highest level at which the
/// force stays still, the one with less noise, or else the one at the ends of the recording. `None` if it never stays still.
pub(crate) fn resting_level(force: &Samples) -> Option<f64> {
    let (time_s, values) = force.coarse();
    let count = time_s.len();
    let step_s = (time_s.last()? - time_s.first()?) / (count.max(2) - 1) as f64;
    let window = ((WINDOW_S / step_s).round() as usize).clamp(4, count.max(4));
    let mut windows: Vec<(f64, f64)> = Vec::new();
    for start in (0..count.saturating_sub(window)).step_by((window / 2).max(1)) {
        let part = &values[start..start + window];
        if part.iter().any(|value| !value.is_finite()) {
            continue;
        }
        let mean = part.iter().sum::<f64>() / window as f64;
        let variance = part.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / window as f64;
        windows.push((mean, variance.sqrt()));
    }
    let quietest = windows
        .iter()
        .map(|(_, deviation)| *deviation)
        .fold(f64::INFINITY, f64::min);
    let range = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let limit = (4.0 * quietest).max(0.01 * (high - low));
    let still: Vec<(usize, f64, f64)> = (0..)
        .zip(&windows)
        .filter(|(_, (_, deviation))| *deviation <= limit)
        .map(|(place, (mean, deviation))| (place, *mean, *deviation))
        .collect();
    let means = still.iter().map(|(_, mean, _)| *mean);
    let (lowest, highest) = means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| {
        (low.min(mean), high.max(mean))
    });
    // Windows at the lowest level and at the highest, within the noise of their samples.
    let group = |level: f64| -> Vec<(usize, f64, f64)> {
        let near = still
            .iter()
            .filter(|(_, mean, _)| (mean - level).abs() <= limit);
        near.copied().collect()
    };
    let (low_group, high_group) = (group(lowest), group(highest));
    let noise = |group: &[(usize, f64, f64)]| {
        statistics::median(group.iter().map(|(_, _, deviation)| *deviation))
    };
    let ends = |group: &[(usize, f64, f64)]| {
        let is_at_end = |(place, _, _): &&(usize, f64, f64)| {
            let share = *place as f64 / windows.len() as f64;
            !(0.1..=0.9).contains(&share)
        };
        group.iter().filter(is_at_end).count()
    };
    let (low_noise, high_noise) = (noise(&low_group)?, noise(&high_group)?);
    // Without a finger there is the sensor's noise alone; where a finger is as quiet, the ends of a recording are without one.
    let is_high = if high_noise < 0.5 * low_noise {
        true
    } else if low_noise < 0.5 * high_noise {
        false
    } else {
        ends(&high_group) > ends(&low_group)
    };
    let rest = if is_high { high_group } else { low_group };
    statistics::median(rest.into_iter().map(|(_, mean, _)| mean))
}

/// Returns the mean force over stretches without contact, s on the drive's clock.
pub(crate) fn without_contact(force: &Samples, stretches_s: &[(f64, f64)]) -> Option<Tare> {
    let (time_s, values) = force.coarse();
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0f64);
    let mut means = Vec::new();
    for &(from_s, to_s) in stretches_s {
        let (mut part, mut n) = (0.0, 0.0f64);
        for (time_s, value) in time_s.iter().zip(&values) {
            if (from_s + MARGIN_S..=to_s - MARGIN_S).contains(time_s) && value.is_finite() {
                part += value;
                n += 1.0;
                sum += value;
                square += value * value;
                count += 1.0;
            }
        }
        if n > 0.0 {
            means.push(part / n);
        }
    }
    if count < 1.0 {
        return None;
    }
    let mean = sum / count;
    // Drift and hum are alike over a tenth of a second.
    let variance = (square / count - mean * mean).max(0.0);
    let stretch_variance =
        means.iter().map(|part| (part - mean).powi(2)).sum::<f64>() / (means.len() as f64).max(1.0);
    let independent = (count / 100.0).max(1.0);
    Some(Tare {
        newtons: mean,
        error: (variance / independent + stretch_variance / (means.len() as f64).max(1.0)).sqrt(),
    })
}

/// Returns the lateral force that strokes there and back have in common: that of F = tare + μ N sign(v), with the same μ in both
/// directions, over the strokes' means. `None` without strokes in both directions.
pub(crate) fn symmetric_strokes(
    lateral: &Samples,
    normal: Option<&Samples>,
    strokes: &[(Direction, f64, f64)],
) -> Option<Tare> {
    let (time_s, values) = lateral.coarse();
    let mut points: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for &(direction, from_s, to_s) in strokes {
        let (mut force, mut load, mut count) = (0.0, 0.0, 0.0f64);
        for (time_s, value) in time_s.iter().zip(&values) {
            let pressed = normal.map_or(1.0, |normal| normal.at(*time_s));
            if (from_s..=to_s).contains(time_s) && value.is_finite() && pressed.is_finite() {
                force += value;
                load += pressed;
                count += 1.0;
            }
        }
        if count > 0.0 {
            let side = usize::from(direction == Direction::RightToLeft);
            points[side].push((load / count, force / count));
        }
    }
    if points.iter().any(Vec::is_empty) {
        return None;
    }
    // Least squares of F = t + c s N with s = ±1, in which the directions have equal weights.
    let mut sums = [0.0; 5];
    for (side, points) in points.iter().enumerate() {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let weight = 1.0 / points.len() as f64;
        for (load, force) in points {
            let x = sign * load;
            let terms = [
                weight,
                weight * x,
                weight * x * x,
                weight * force,
                weight * x * force,
            ];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += term;
            }
        }
    }
    let [w, wx, wxx, wf, wxf] = sums;
    let determinant = w * wxx - wx * wx;
    if determinant == 0.0 {
        return None;
    }
    let tare = (wf * wxx - wx * wxf) / determinant;
    let slope = (w * wxf - wx * wf) / determinant;
    let residuals = points.iter().enumerate().flat_map(|(side, points)| {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        points
            .iter()
            .map(move |(load, force)| (force - tare - slope * sign * load).powi(2))
    });
    let count = points.iter().map(Vec::len).sum::<usize>() as f64;
    let variance = residuals.sum::<f64>() / (count - 2.0).max(1.0);
    // With one stroke each way the line is exact, and the strokes' difference of friction is not known: 5 % of it is assumed.
    let assumed = 0.05 * slope.abs() * wxx.sqrt() / 2f64.sqrt();
    let error = if count > 2.0 {
        (variance * wxx / determinant).sqrt()
    } else {
        assumed
    };
    Some(Tare {
        newtons: tare,
        error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{PlacedClock, Times};

    fn samples(value: impl Fn(f64) -> f64) -> Samples {
        Samples {
            times: Times::Even {
                first_s: 0.0,
                step_s: 1e-3,
            },
            values: (0..6000)
                .map(|n| value(f64::from(n) * 1e-3) + 0.003 * (f64::from(n) * 1.7).sin())
                .collect(),
            clock: PlacedClock {
                offset_s: 0.0,
                ppm: 0.0,
            },
        }
    }

    fn pressed(t: f64) -> f64 {
        if (1.0..5.0).contains(&t) {
            0.6 + 0.05 * (9.0 * t).sin()
        } else {
            0.0
        }
    }

    #[test]
    fn the_normal_force_rests_at_its_tare() {
        let force = samples(|t| pressed(t) + 0.37);
        let level = resting_level(&force).unwrap();
        assert!((level - 0.37).abs() < 0.01, "{level}");
        let upside_down = samples(|t| -pressed(t) + 0.37);
        let level = resting_level(&upside_down).unwrap();
        assert!((level - 0.37).abs() < 0.01, "{level}");
        let tare = without_contact(&force, &[(0.1, 0.9), (5.1, 5.9)]).unwrap();
        assert!(
            (tare.newtons - 0.37).abs() < 1e-3 && tare.error < 2e-3,
            "{tare:?}"
        );
        assert_eq!(without_contact(&force, &[]), None);
    }

    #[test]
    fn strokes_there_and_back_show_the_lateral_tare() {
        let normal = samples(pressed);
        let lateral = samples(|t| 0.12 + 0.7 * pressed(t) * if t < 3.0 { 1.0 } else { -1.0 });
        let strokes = [
            (Direction::LeftToRight, 1.2, 2.8),
            (Direction::RightToLeft, 3.2, 4.8),
        ];
        let tare = symmetric_strokes(&lateral, Some(&normal), &strokes).unwrap();
        assert!((tare.newtons - 0.12).abs() < 2e-3, "{tare:?}");
        assert_eq!(
            symmetric_strokes(&lateral, Some(&normal), &strokes[..1]),
            None
        );
    }
}
