//! Stretches in which the normal force is as steady as without a finger, at another level.
//!
//! The noise of a sensor without a finger is known from the intervals without one. A hand trembles and drifts by more, so that a stretch
//! as steady as those, elsewhere than at their level, is a zero that moved, or a weight at rest.

use recording::ForceRow;
use statistics::StraightLine;

use crate::Column;

/// Length of a stretch, s, and time from one to the next.
const STRETCH_S: f64 = 0.4;
const STEP_S: f64 = 0.1;
/// Fewest rows of a stretch.
const FEWEST: usize = 40;
/// Largest scatter of a stretch without a finger, relative to that of the steadiest in the intervals without one.
const STEADY: f64 = 1.5;
/// Smallest distance from the level of these intervals, N and in scatters, and greatest slope, N/s.
const SMALLEST_N: f64 = 0.03;
const CLEAR: f64 = 6.0;
const STEEPEST_N_PER_S: f64 = 0.1;
/// Shortest time for which the force is steady, s.
const SHORTEST_S: f64 = 0.7;

/// Stretch of a steady normal force away from zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovedZero {
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Mean normal force, N.
    pub normal_n: f64,
}

/// Level of a stretch.
#[derive(Debug, Clone, Copy)]
struct Level {
    from_s: f64,
    normal_n: f64,
    /// Scatter about a straight line of normal and lateral force, N.
    scatter_n: [f64; 2],
    slope_n_per_s: f64,
}

/// Returns the longest stretch outside the intervals `unloaded_s` in which both forces are as steady as in them, and the normal force is
/// elsewhere.
#[must_use]
pub fn moved_zero(rows: &[ForceRow], unloaded_s: &[(f64, f64)]) -> Option<MovedZero> {
    let levels = levels(rows);
    let is_unloaded = |level: &Level| {
        let mut spans = unloaded_s.iter();
        spans.any(|span| span.0 <= level.from_s && level.from_s + STRETCH_S <= span.1)
    };
    let touches_unloaded = |level: &Level| {
        let mut spans = unloaded_s.iter();
        spans.any(|span| span.0 < level.from_s + STRETCH_S && level.from_s < span.1)
    };
    let free = || levels.iter().filter(|level| is_unloaded(level));
    let steadiest_n = [0, 1].map(|axis: usize| {
        let scatters_n = free().map(|level| level.scatter_n[axis]);
        scatters_n
            .filter(|scatter_n| *scatter_n > 0.0)
            .reduce(f64::min)
    });
    let [normal_n, lateral_n] = steadiest_n;
    let limits_n = [normal_n?, lateral_n?].map(|scatter_n| STEADY * scatter_n);
    let least_n = SMALLEST_N.max(CLEAR * normal_n?);
    let is_away =
        |level: &Level| free().all(|free| (level.normal_n - free.normal_n).abs() > least_n);
    let is_moved = |level: &Level| {
        let is_steady = [0, 1].iter().all(|&axis: &usize| {
            level.scatter_n[axis] > 0.0 && level.scatter_n[axis] < limits_n[axis]
        });
        is_steady && level.slope_n_per_s.abs() < STEEPEST_N_PER_S && is_away(level)
    };
    let candidates: Vec<&Level> = { levels.iter() }
        .filter(|level| !touches_unloaded(level) && is_moved(level))
        .collect();
    let runs = candidates.chunk_by(|level, next| next.from_s - level.from_s < 1.5 * STEP_S);
    let stretches = runs.map(|run| MovedZero {
        from_s: run[0].from_s,
        to_s: run[run.len() - 1].from_s + STRETCH_S,
        normal_n: run.iter().map(|level| level.normal_n).sum::<f64>() / run.len() as f64,
    });
    let length_s = |stretch: &MovedZero| stretch.to_s - stretch.from_s;
    stretches
        .max_by(|a, b| length_s(a).total_cmp(&length_s(b)))
        .filter(|longest| length_s(longest) >= SHORTEST_S)
}

/// Returns the levels of all stretches with rows throughout.
fn levels(rows: &[ForceRow]) -> Vec<Level> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Vec::new();
    };
    let count = ((last.time_s - first.time_s - STRETCH_S) / STEP_S).max(0.0) as usize;
    let level = |index: usize| {
        let from_s = first.time_s + index as f64 * STEP_S;
        let place = |time_s: f64| rows.partition_point(|row| row.time_s < time_s);
        let inside = rows.get(place(from_s)..place(from_s + STRETCH_S))?;
        let line = |value: Column| {
            let points: Vec<(f64, f64)> = { inside.iter() }
                .map(|row| (row.time_s, value(row)))
                .collect();
            StraightLine::fit(&points).filter(|_| points.len() >= FEWEST)
        };
        let (normal, lateral) = (line(|row| row.normal_n)?, line(|row| row.lateral_n)?);
        Some(Level {
            from_s,
            normal_n: normal.middle.1,
            scatter_n: [normal.residual, lateral.residual],
            slope_n_per_s: normal.slope,
        })
    };
    (0..count.min(100_000)).filter_map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings at 1 kHz of 8 s with noise of 2 mN, by a generator of Numerical Recipes: a finger touches from 2 to 4 s.
    fn rows(zero: fn(f64) -> f64, press: fn(f64) -> f64) -> Vec<ForceRow> {
        let mut state = 1u64;
        let mut noise_n = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            7e-3 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        };
        let row = |step: u32| {
            let time_s = f64::from(step) * 1e-3;
            let press_n = if (2.0..4.0).contains(&time_s) {
                press(time_s)
            } else {
                0.0
            };
            ForceRow {
                time_s,
                normal_n: press_n + zero(time_s) + noise_n(),
                lateral_n: 0.4 * press_n + noise_n(),
            }
        };
        (0..8000).map(row).collect()
    }

    fn hand(time_s: f64) -> f64 {
        0.6 + 0.02 * (60.0 * time_s).sin() + 0.05 * (7.0 * time_s).sin()
    }

    #[test]
    fn a_zero_that_moves_is_found_and_a_hand_is_not_one() {
        let unloaded_s = [(0.0, 1.8)];
        let found = |zero| moved_zero(&rows(zero, hand), &unloaded_s);
        let step = found(|t| if t < 4.2 { 0.0 } else { 0.2 }).unwrap();
        assert!((step.normal_n - 0.2).abs() < 2e-3, "{step:?}");
        assert!(step.from_s < 4.5 && step.to_s > 7.7, "{step:?}");
        let drift = found(|t| -0.04 * (t - 2.0).max(0.0)).unwrap();
        assert!(drift.normal_n < -0.08, "{drift:?}");
        assert_eq!(found(|_| 0.0), None);
        assert_eq!(found(|_| 0.3), None);
        // The zero is read there.
        let known = [(0.0, 1.8), (4.5, 8.0)];
        let step = rows(|t| if t < 4.2 { 0.0 } else { 0.2 }, hand);
        assert_eq!(moved_zero(&step, &known), None);
        assert_eq!(moved_zero(&step, &[]), None);
        assert_eq!(moved_zero(&[], &unloaded_s), None);
    }
}
