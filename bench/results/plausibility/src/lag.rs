//! Positions that come late or early against the friction, by strokes in both directions.
//!
//! The friction f_t acts against the finger, so that its sign is that of the velocity v. With the lag s of the positions,
//!
//! ```text
//! A(s) = Σ f_t(t) sgn v(t + s) / Σ |f_t(t)|
//! ```
//!
//! over the times at which the finger presses and moves is 1 at the true lag, and less by twice the share of the time in which the
//! shifted velocity has the other sign.

use recording::{ForceRow, PositionRow};

use crate::cells::{MOVING_SHARE, MovingCell, moving_cells, moving_m_per_s};
use crate::implausible::Implausible;

/// Length of a mean of forces, and step of the lag, s.
const CELL_S: f64 = 0.02;
/// Largest lag, s.
const LARGEST_S: f64 = 2.0;
/// Agreement of the right lag, and that below which a lag of none is wrong.
const RIGHT: f64 = 0.95;
const WRONG: f64 = 0.8;
/// Smallest lag, s, and smallest way in it, m: a finger pad is stretched by less before it slips the other way.
const SMALLEST_S: f64 = 0.15;
const SMALLEST_WAY_M: f64 = 0.015;
/// Smallest share of the cells in which the finger moves the less frequent way, and fewest cells.
const LEAST_WAY_SHARE: f64 = 0.2;
const FEWEST: usize = 50;

/// Returns the finding of positions that come late or early against the lateral force; the finger presses with `contact_n` or more.
pub(crate) fn position_lag(
    force: &[ForceRow],
    position: &[PositionRow],
    contact_n: f64,
) -> Option<Implausible> {
    let cells = moving_cells(force, position, CELL_S)?;
    let moving_m_per_s = moving_m_per_s(cells.iter())?;
    let usual_m_per_s = moving_m_per_s / MOVING_SHARE;
    let agreement = |lag: i64| agreement(&cells, lag, (contact_n, moving_m_per_s));
    let unshifted = agreement(0)?;
    // Friction against every slide is a lateral force upside down.
    if unshifted.abs() >= WRONG {
        return None;
    }
    let largest = (LARGEST_S / CELL_S) as i64;
    let is_right = |lag: &i64| agreement(*lag).is_some_and(|value| value >= RIGHT);
    let first = (1..=largest).flat_map(|lag| [lag, -lag]).find(is_right)?;
    // Between strokes the finger may pause, so that several lags are right: their middle is taken.
    let way = first.signum();
    let last = (1..=largest)
        .map(|further| first + way * further)
        .take_while(|lag| lag.abs() <= largest && is_right(lag))
        .last();
    let late_s = 0.5 * (first + last.unwrap_or(first)) as f64 * CELL_S;
    let is_certain = late_s.abs() >= SMALLEST_S && late_s.abs() * usual_m_per_s >= SMALLEST_WAY_M;
    is_certain.then_some(Implausible::PositionsLate { late_s })
}

/// Returns the agreement of the lateral force with the direction `lag` cells later; `None` with too few cells, or of one direction.
fn agreement(
    cells: &[MovingCell],
    lag: i64,
    (contact_n, moving_m_per_s): (f64, f64),
) -> Option<f64> {
    let (mut with, mut all, mut ways) = (0.0, 0.0, [0usize; 2]);
    for (index, cell) in (0i64..).zip(cells) {
        let shifted = usize::try_from(index + lag)
            .ok()
            .and_then(|index| cells.get(index));
        let Some(shifted) = shifted.filter(|_| cell.force.normal_n >= contact_n) else {
            continue;
        };
        if shifted.speed_m_per_s.abs() >= moving_m_per_s {
            with += cell.force.lateral_n * shifted.speed_m_per_s.signum();
            all += cell.force.lateral_n.abs();
            ways[usize::from(shifted.speed_m_per_s > 0.0)] += 1;
        }
    }
    let count = ways[0] + ways[1];
    let is_both = ways[0].min(ways[1]) as f64 >= LEAST_WAY_SHARE * count as f64;
    (count >= FEWEST && is_both && all > 0.0).then(|| with / all)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A finger that rubs 80 mm there and back three times, with a pause of `pause_s` at each end, presses with 0.6 N throughout, and
    /// whose pad slips 10 mm behind a turn; its positions come `late_s` late.
    fn rubbing(late_s: f64, pause_s: f64) -> (Vec<ForceRow>, Vec<PositionRow>) {
        let stroke_s = 1.6;
        let way = |time_s: f64| {
            let stroke = ((time_s - 1.0) / (stroke_s + pause_s)).clamp(0.0, 6.0);
            let share = (stroke.fract() * (stroke_s + pause_s) / stroke_s).min(1.0);
            let is_back = stroke as usize % 2 == 1;
            let is_moving = share > 0.0 && share < 1.0;
            let pulls = if is_back { -1.0 } else { 1.0 };
            let at_m = if is_back {
                0.08 * (1.0 - share)
            } else {
                0.08 * share
            };
            (at_m, if is_moving { pulls } else { 0.0 })
        };
        let duration_s = 2.0 + 6.0 * (stroke_s + pause_s);
        let times = (0..(duration_s * 1e3) as u32).map(|i| f64::from(i) * 1e-3);
        let force = times.clone().map(|time_s| ForceRow {
            time_s,
            normal_n: 0.6,
            lateral_n: 0.6 * way(time_s - 0.1).1 * (0.5 + 0.4 * (TAU * 6.0 * time_s).sin()),
        });
        let position = times.map(|time_s| PositionRow {
            time_s,
            position_m: way(time_s - late_s).0,
        });
        (force.collect(), position.collect())
    }

    fn late_s(late_s: f64, pause_s: f64) -> Option<f64> {
        let (force, position) = rubbing(late_s, pause_s);
        match position_lag(&force, &position, 0.1)? {
            Implausible::PositionsLate { late_s } => Some(late_s),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn late_and_early_positions_are_found() {
        for (lag_s, pause_s) in [(0.6, 0.0), (-0.4, 0.0), (1.0, 0.3), (-1.2, 0.5), (0.9, 0.1)] {
            let found_s = late_s(lag_s, pause_s).unwrap_or(f64::NAN);
            // The pad follows 0.1 s behind.
            assert!(
                (found_s - (lag_s - 0.1)).abs() < 0.06,
                "{lag_s} s: {found_s} s"
            );
        }
    }

    #[test]
    fn positions_in_time_or_of_one_way_have_no_lag() {
        for pause_s in [0.0, 0.3, 1.0] {
            for lag_s in [0.0, 0.05, 0.1, -0.05] {
                assert_eq!(late_s(lag_s, pause_s), None, "{lag_s} s");
            }
        }
        let (mut force, position) = rubbing(0.8, 0.3);
        force.retain(|row| row.time_s < 2.5);
        let first = position.iter().position(|row| row.time_s > 2.5).unwrap();
        assert_eq!(position_lag(&force, &position[..first], 0.1), None);
        // Upside down.
        let (mut force, position) = rubbing(0.0, 0.3);
        force.iter_mut().for_each(|row| row.lateral_n *= -1.0);
        assert_eq!(position_lag(&force, &position, 0.1), None);
        assert_eq!(position_lag(&[], &position, 0.1), None);
        // A clock that jumps by two months.
        let (mut force, position) = rubbing(0.8, 0.3);
        force.last_mut().unwrap().time_s += 5e6;
        assert_eq!(position_lag(&force, &position, 0.1), None);
    }
}
