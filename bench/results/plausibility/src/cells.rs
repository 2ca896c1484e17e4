//! Means of forces and positions in cells of equal length.

use recording::{ForceRow, PositionRow};
use statistics::quantile;

/// Most cells: three hours of 10 ms. Times that jump would need any number of them.
const MOST_CELLS: f64 = 1e6;

/// Share of the usual speed from which on a finger moves.
pub(crate) const MOVING_SHARE: f64 = 0.25;

/// Means of the forces in a cell, N; NaN where there are no readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) normal_n: f64,
    pub(crate) lateral_n: f64,
}

/// Returns the number of cells of `cell_s` in a span; `None` without any, or with too many.
pub(crate) fn count((start_s, end_s): (f64, f64), cell_s: f64) -> Option<usize> {
    let count = ((end_s - start_s) / cell_s).ceil();
    (1.0..MOST_CELLS).contains(&count).then_some(count as usize)
}

/// Returns the cell in which a time lies, of `count`.
pub(crate) fn place(time_s: f64, start_s: f64, cell_s: f64, count: usize) -> usize {
    (((time_s - start_s) / cell_s) as usize).min(count - 1)
}

/// Returns the means of the finite readings in cells of `cell_s` from `start_s` to `end_s`.
pub(crate) fn force_cells(
    rows: &[ForceRow],
    (start_s, end_s): (f64, f64),
    cell_s: f64,
) -> Option<Vec<Cell>> {
    let count = count((start_s, end_s), cell_s)?;
    let mut sums = vec![[0.0; 3]; count];
    let is_finite = |row: &&ForceRow| (row.normal_n + row.lateral_n).is_finite();
    for row in rows.iter().filter(is_finite) {
        let sum = &mut sums[place(row.time_s, start_s, cell_s, count)];
        sum[0] += row.normal_n;
        sum[1] += row.lateral_n;
        sum[2] += 1.0;
    }
    let cell = |[normal, lateral, n]: [f64; 3]| Cell {
        normal_n: normal / n,
        lateral_n: lateral / n,
    };
    Some(sums.into_iter().map(cell).collect())
}

/// Forces and velocity in a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingCell {
    pub(crate) force: Cell,
    pub(crate) speed_m_per_s: f64,
}

/// Returns means of the forces, and velocities of the positions, NaN where there are none, in cells of `cell_s`; `None` without both.
pub(crate) fn moving_cells(
    force: &[ForceRow],
    position: &[PositionRow],
    cell_s: f64,
) -> Option<Vec<MovingCell>> {
    let start_s = force.first()?.time_s.min(position.first()?.time_s);
    let end_s = force.last()?.time_s.max(position.last()?.time_s);
    let forces = force_cells(force, (start_s, end_s), cell_s)?;
    let mut places = vec![[0.0; 2]; forces.len()];
    for row in position.iter().filter(|row| row.position_m.is_finite()) {
        let sum = &mut places[place(row.time_s, start_s, cell_s, forces.len())];
        sum[0] += row.position_m;
        sum[1] += 1.0;
    }
    let position_m = |cell: usize| places.get(cell).map_or(f64::NAN, |[sum, n]| sum / n);
    let cell = |(index, force): (usize, Cell)| {
        let before_m = index.checked_sub(1).map_or(f64::NAN, position_m);
        MovingCell {
            force,
            speed_m_per_s: (position_m(index + 1) - before_m) / (2.0 * cell_s),
        }
    };
    Some(forces.into_iter().enumerate().map(cell).collect())
}

/// Returns the speed from which on a finger moves, m/s: a share of that which a tenth of these cells exceed.
pub(crate) fn moving_m_per_s<'a>(cells: impl Iterator<Item = &'a MovingCell>) -> Option<f64> {
    let speeds = cells.map(|cell| cell.speed_m_per_s.abs());
    let mut speeds: Vec<f64> = speeds.filter(|speed| speed.is_finite()).collect();
    speeds.sort_by(f64::total_cmp);
    quantile(&speeds, 0.9).map(|usual_m_per_s| MOVING_SHARE * usual_m_per_s)
}
