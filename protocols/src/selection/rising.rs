//! Rising stretches of the vibration amplitude.
//!
//! 1. Frames without a usable amplitude are bridged by straight lines, so that a gap does not move the turning points
//!    around it.
//! 2. The amplitude is smoothed by a centred Hann window of 5 ms, which leaves a 50 Hz modulation 0.9 of its depth.
//! 3. Turning points alternate; each is confirmed when the amplitude has come back from it by a fifth of the range
//!    (2nd to 98th percentile), at least by 5 % of the amplitude: noise confirms no turning point, and an unmodulated
//!    amplitude has no rising stretch.
//! 4. A turning point's time is the middle of the time around it that the amplitude spends within 5 % of its swing,
//!    which noise moves far less than the extreme frame itself.

use super::series::{ExplorationSeries, Validity};
use std::f64::consts::TAU;

/// A stretch of rising amplitude, from a minimum to the next maximum.
pub(super) struct Rising {
    pub start_s: f64,
    pub end_s: f64,
    /// Whether the series began after the minimum or ended before the maximum.
    pub cut_off: bool,
}

/// Length of the smoothing window, s.
const SMOOTHING_S: f64 = 0.005;
/// Fraction of the amplitude's range by which it must come back to confirm a turning point.
const TURN_PART_OF_RANGE: f64 = 0.2;
/// Fraction of the amplitude by which it must at least come back.
const TURN_PART_OF_AMPLITUDE: f64 = 0.05;
/// Fraction of the swing within which the amplitude counts as at its turning point.
const TIP_PART_OF_SWING: f64 = 0.05;

/// Returns the rising stretches in order.
pub(super) fn stretches(series: &ExplorationSeries<'_>) -> Vec<Rising> {
    let time_s = series.time_s;
    let Some(amplitude_m) = bridge(series) else {
        return Vec::new();
    };
    if time_s.len() < 3 {
        return Vec::new();
    }
    let frame_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    let half = (0.5 * SMOOTHING_S / frame_s).floor() as usize;
    let smooth = smooth(&amplitude_m, half);
    let turns = turning_points(&smooth, swing_that_turns(&smooth));
    let last = smooth.len() - 1;
    turns
        .windows(2)
        .filter(|pair| smooth[pair[1]] > smooth[pair[0]])
        .map(|pair| Rising {
            start_s: tip_s(&smooth, time_s, pair[0], &turns),
            end_s: tip_s(&smooth, time_s, pair[1], &turns),
            // Within the smoothing window of an end, an extreme may be an artefact of the end.
            cut_off: pair[0] <= half || pair[1] + half >= last,
        })
        .collect()
}

/// Returns the amplitude with unusable frames replaced by the straight line between their neighbours; `None` if no
/// frame is usable.
fn bridge(series: &ExplorationSeries<'_>) -> Option<Vec<f64>> {
    let is_usable = |i: usize| {
        series.amplitude_m[i].is_finite()
            && matches!(
                series.validity[i],
                Validity::Valid | Validity::BelowNoise | Validity::ForceSaturated
            )
    };
    let usable_frames: Vec<usize> = (0..series.time_s.len()).filter(|&i| is_usable(i)).collect();
    let (first, last) = (*usable_frames.first()?, *usable_frames.last()?);
    let mut amplitude_m = series.amplitude_m.to_vec();
    amplitude_m[..first].fill(series.amplitude_m[first]);
    amplitude_m[last + 1..].fill(series.amplitude_m[last]);
    for pair in usable_frames.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let slope = (amplitude_m[b] - amplitude_m[a]) / (b - a) as f64;
        for i in a + 1..b {
            amplitude_m[i] = amplitude_m[a] + slope * (i - a) as f64;
        }
    }
    Some(amplitude_m)
}

/// Smooths by a centred Hann window of `2 half + 1` frames; at the ends, by the normalised part of it that lies inside.
fn smooth(x: &[f64], half: usize) -> Vec<f64> {
    let weight = |offset: usize| 0.5 + 0.5 * (TAU * offset as f64 / (2 * half + 2) as f64).cos();
    let weights: Vec<f64> = (0..=half).map(weight).collect();
    (0..x.len())
        .map(|i| {
            let window = i.saturating_sub(half)..(i + half + 1).min(x.len());
            let (sum, norm) = window.fold((0.0, 0.0), |(sum, norm), j| {
                let w = weights[i.abs_diff(j)];
                (sum + w * x[j], norm + w)
            });
            sum / norm
        })
        .collect()
}

/// Returns the change of amplitude that confirms a turning point, m.
fn swing_that_turns(x: &[f64]) -> f64 {
    let mut order_statistics = x.to_vec();
    order_statistics.sort_unstable_by(f64::total_cmp);
    let quantile =
        |q: f64| order_statistics[(q * (order_statistics.len() - 1) as f64).round() as usize];
    let (low, high) = (quantile(0.02), quantile(0.98));
    (TURN_PART_OF_RANGE * (high - low)).max(TURN_PART_OF_AMPLITUDE * high)
}

/// Returns the indices of alternating minima and maxima that differ by at least `swing`; the first and last are the
/// extremes before the first and after the last confirmed turn.
fn turning_points(x: &[f64], swing: f64) -> Vec<usize> {
    #[derive(PartialEq)]
    enum Trend {
        Unknown,
        Rising,
        Falling,
    }
    let mut turns = Vec::new();
    let mut trend = Trend::Unknown;
    let (mut lowest, mut highest) = (0, 0);
    for i in 1..x.len() {
        if x[i] < x[lowest] {
            lowest = i;
        }
        if x[i] > x[highest] {
            highest = i;
        }
        if trend != Trend::Rising && x[i] - x[lowest] > swing {
            turns.push(lowest);
            trend = Trend::Rising;
            highest = i;
        } else if trend != Trend::Falling && x[highest] - x[i] > swing {
            turns.push(highest);
            trend = Trend::Falling;
            lowest = i;
        }
    }
    match trend {
        Trend::Rising => turns.push(highest),
        Trend::Falling => turns.push(lowest),
        Trend::Unknown => {}
    }
    turns
}

/// Returns the time of a turning point, s.
fn tip_s(x: &[f64], time_s: &[f64], turn: usize, turns: &[usize]) -> f64 {
    let index = turns.partition_point(|&t| t < turn);
    let previous = index.checked_sub(1).map(|i| turns[i]);
    let next = turns.get(index + 1).copied();
    let swing = [previous, next]
        .into_iter()
        .flatten()
        .map(|neighbour| (x[neighbour] - x[turn]).abs())
        .fold(f64::INFINITY, f64::min);
    let in_tip = |i: &usize| (x[*i] - x[turn]).abs() <= TIP_PART_OF_SWING * swing;
    let first = (previous.unwrap_or(0)..=turn)
        .rev()
        .take_while(in_tip)
        .last();
    let last = (turn..=next.unwrap_or(x.len() - 1))
        .take_while(in_tip)
        .last();
    match (first, last) {
        // At an end of the series half of the tip is missing, so that its middle is meaningless.
        (Some(first), Some(last)) if first > 0 && last + 1 < x.len() => {
            0.5 * (time_s[first] + time_s[last])
        }
        _ => time_s[turn],
    }
}
