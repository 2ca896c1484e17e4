//! A lateral force that is late or early against the normal force: friction where nothing presses.
//!
//! Friction is a share of the normal force, and vanishes with it. With the lag s of the lateral force,
//!
//! ```text
//! U(s) = number of cells in which |f_t(t)| is large and f_n(t − s) is none
//! ```
//!
//! is 0 at the true lag and at larger ones up to the time for which the finger rests before it slides, so that the smallest lag
//! without such cells is a lower bound.

use recording::ForceRow;
use statistics::quantile;

use crate::implausible::Implausible;

/// Length of a mean of forces, and step of the lag, s.
const CELL_S: f64 = 0.01;
/// Most cells: three hours. Times that jump would need any number of them.
const MOST_CELLS: f64 = 1e6;
/// Smallest and largest lag, s: a finger that lifts off leaves both axes within 10 ms.
const SMALLEST_S: f64 = 0.03;
const LARGEST_S: f64 = 1.0;
/// Share of the usual greatest lateral force from which on it is large.
const LARGE: f64 = 0.35;
/// Fewest cells with a large force where nothing presses, and their smallest share of all with a large one.
const FEWEST: usize = 4;
const SMALLEST_SHARE: f64 = 0.02;
/// Share of the cells under the normal force in which a lateral one is large if it is the normal one, and greatest share of the others.
const ALWAYS: f64 = 0.97;
const OFTEN: f64 = 0.6;
/// Share of them that may be left at the lag.
const LEFT: f64 = 0.1;

/// Returns the finding of a lateral force where nothing presses, by rows taken against their zero: it comes late or early against the normal
/// force, or is the normal one; the finger touches with `contact_n` or more.
#[must_use]
pub fn lateral_without_normal(rows: &[ForceRow], contact_n: f64) -> Option<Implausible> {
    let cells = cells(rows)?;
    let presses = |cell: &[f64; 2]| cell[0] >= 0.5 * contact_n;
    let mut under_press: Vec<f64> = cells
        .iter()
        .filter(|cell| presses(cell))
        .map(|cell| cell[1].abs())
        .filter(|lateral_n| lateral_n.is_finite())
        .collect();
    under_press.sort_by(f64::total_cmp);
    let large_n = LARGE * quantile(&under_press, 0.95)?;
    let is_large = |(_, cell): &(usize, &[f64; 2])| cell[1].abs() > large_n;
    let large: Vec<usize> = cells
        .iter()
        .enumerate()
        .filter(is_large)
        .map(|(index, _)| index)
        .collect();
    let unpressed = |lag: i64| {
        let is_unpressed = |index: &&usize| {
            let pressed = i64::try_from(**index)
                .ok()
                .and_then(|index| usize::try_from(index - lag).ok())
                .and_then(|index| cells.get(index));
            // Beyond the ends nothing is known.
            pressed.is_some_and(|cell| cell[0].is_finite() && !presses(cell))
        };
        large.iter().filter(is_unpressed).count()
    };
    let at_once = unpressed(0);
    if at_once < FEWEST.max((SMALLEST_SHARE * large.len() as f64).ceil() as usize) {
        return None;
    }
    let most_left = (LEFT * at_once as f64).floor() as usize;
    let lags = (1..=(LARGEST_S / CELL_S) as i64).flat_map(|lag| [lag, -lag]);
    if let Some(lag) = { lags }.find(|lag| unpressed(*lag) <= most_left) {
        let late_s = lag as f64 * CELL_S;
        return (late_s.abs() >= SMALLEST_S).then_some(Implausible::LateralLag { late_s });
    }
    let known = || {
        cells
            .iter()
            .filter(|cell| cell[0].is_finite() && cell[1].is_finite())
    };
    let share_large = |is_pressed: bool| {
        let inside = known().filter(move |cell| presses(cell) == is_pressed);
        let large = inside
            .clone()
            .filter(|cell| cell[1].abs() > large_n)
            .count();
        large as f64 / inside.count().max(1) as f64
    };
    // Friction may be small under a pressing finger, and a wrong zero is everywhere.
    let is_other = share_large(true) > ALWAYS && share_large(false) < OFTEN;
    is_other.then_some(Implausible::LateralAlone {
        alone_s: at_once as f64 * CELL_S,
    })
}

/// Returns the means of normal and lateral force in cells of equal length, NaN where there are none.
fn cells(rows: &[ForceRow]) -> Option<Vec<[f64; 2]>> {
    let (start_s, end_s) = (rows.first()?.time_s, rows.last()?.time_s);
    let count = ((end_s - start_s) / CELL_S).ceil();
    if !(1.0..MOST_CELLS).contains(&count) {
        return None;
    }
    let mut sums = vec![[0.0; 3]; count as usize];
    for row in rows {
        let place = (((row.time_s - start_s) / CELL_S) as usize).min(count as usize - 1);
        let sum = &mut sums[place];
        sum[0] += row.normal_n;
        sum[1] += row.lateral_n;
        sum[2] += 1.0;
    }
    let means = sums
        .iter()
        .map(|[normal, lateral, n]| [normal / n, lateral / n]);
    Some(means.collect())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Two strokes of 1.2 s at 1 kHz, of a finger that rests for `rest_s` before it slides; the lateral force comes `late_s` late.
    fn strokes(late_s: f64, rest_s: f64) -> Vec<ForceRow> {
        let stroke = |time_s: f64| {
            let since_s = (time_s - 1.0).rem_euclid(2.5);
            (since_s < 1.2 && time_s > 1.0 && time_s < 5.0).then_some(since_s)
        };
        let row = |n: u32| {
            let time_s = f64::from(n) * 1e-3;
            let noise = 0.004 * (7.7 * f64::from(n)).sin();
            let pressed = stroke(time_s).map_or(0.0, |_| 0.65);
            let slid = stroke(time_s - late_s).filter(|since_s| *since_s >= rest_s);
            let friction = slid.map_or(0.0, |since_s| 0.45 + 0.4 * (TAU * 6.0 * since_s).cos());
            ForceRow {
                time_s,
                normal_n: pressed + noise,
                lateral_n: 0.65 * friction - noise,
            }
        };
        (0..6000).map(row).collect()
    }

    #[test]
    fn a_lateral_force_without_a_normal_one_is_late_or_early() {
        for late_s in [0.05, 0.1, 0.3, -0.3, -0.05] {
            let Some(Implausible::LateralLag { late_s: found_s }) =
                lateral_without_normal(&strokes(late_s, 0.0), 0.1)
            else {
                panic!("{late_s} s");
            };
            assert!((found_s - late_s).abs() < 0.07, "{late_s} s: {found_s} s");
        }
    }

    #[test]
    fn forces_together_or_without_a_zero_have_no_lag() {
        for rest_s in [0.0, 0.4] {
            assert_eq!(lateral_without_normal(&strokes(0.0, rest_s), 0.1), None);
        }
        assert_eq!(lateral_without_normal(&strokes(0.01, 0.0), 0.1), None);
        let mut untared = strokes(0.0, 0.0);
        untared.iter_mut().for_each(|row| row.lateral_n += 0.2);
        assert_eq!(lateral_without_normal(&untared, 0.1), None);
        let mut sled = strokes(0.3, 0.0);
        sled.iter_mut().for_each(|row| row.normal_n += 1.0);
        assert_eq!(lateral_without_normal(&sled, 0.1), None, "never lifted");
        assert_eq!(lateral_without_normal(&[], 0.1), None);
    }

    #[test]
    fn exchanged_columns_of_one_stroke_are_named() {
        let mut rows = strokes(0.0, 0.3);
        rows.retain(|row| row.time_s < 3.0);
        for row in &mut rows {
            (row.normal_n, row.lateral_n) = (row.lateral_n, row.normal_n);
        }
        let found = lateral_without_normal(&rows, 0.1);
        assert!(
            matches!(found, Some(Implausible::LateralAlone { .. })),
            "{found:?}"
        );
    }
}
