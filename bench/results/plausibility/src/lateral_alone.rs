//! Friction where nothing presses: a lateral force that is late or early against the normal one, or that is the normal one.
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

use crate::cells::{Cell, force_cells};
use crate::implausible::Implausible;
use crate::lateral_evidence::LateralEvidence;

/// Length of a mean of forces, and step of the lag, s.
const CELL_S: f64 = 0.01;
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

/// Returns the finding of a lateral force where nothing presses, by rows taken against their zero; a finger touches with `contact_n` or
/// more.
pub(crate) fn lateral_without_normal(rows: &[ForceRow], contact_n: f64) -> Option<Implausible> {
    let span_s = (rows.first()?.time_s, rows.last()?.time_s);
    let cells = force_cells(rows, span_s, CELL_S)?;
    let presses = |cell: &Cell| cell.normal_n >= 0.5 * contact_n;
    let under_press = cells.iter().filter(|cell| presses(cell));
    let mut under_press_n: Vec<f64> = under_press.map(|cell| cell.lateral_n.abs()).collect();
    under_press_n.sort_by(f64::total_cmp);
    let large_n = LARGE * quantile(&under_press_n, 0.95)?;
    let is_large = |cell: &Cell| cell.lateral_n.abs() > large_n;
    let large: Vec<usize> = (0..cells.len())
        .filter(|index| is_large(&cells[*index]))
        .collect();
    let unpressed = |lag: i64| {
        let is_unpressed = |index: &&usize| {
            let pressed = i64::try_from(**index)
                .ok()
                .and_then(|index| usize::try_from(index - lag).ok())
                .and_then(|index| cells.get(index));
            // Beyond the ends nothing is known.
            pressed.is_some_and(|cell| cell.normal_n.is_finite() && !presses(cell))
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
        return (late_s.abs() >= SMALLEST_S).then_some(Implausible::LateralLag {
            late_s,
            evidence: LateralEvidence::Press,
        });
    }
    let share_large = |is_pressed: bool| {
        let known = cells.iter().filter(|cell| cell.normal_n.is_finite());
        let inside: Vec<&Cell> = known.filter(|cell| presses(cell) == is_pressed).collect();
        let large = inside.iter().filter(|cell| is_large(cell)).count();
        large as f64 / inside.len().max(1) as f64
    };
    // Friction may be small under a pressing finger, and a wrong zero is everywhere.
    let is_other = share_large(true) > ALWAYS && share_large(false) < OFTEN;
    is_other.then_some(Implausible::LateralAlone {
        alone_s: at_once as f64 * CELL_S,
    })
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
            let Some(Implausible::LateralLag {
                late_s: found_s, ..
            }) = lateral_without_normal(&strokes(late_s, 0.0), 0.1)
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
