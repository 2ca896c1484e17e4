//! Slides through a whole period of the modulation without friction.
//!
//! In each period the amplitude falls to its least, at which a finger that slides and presses has friction: a lateral force that is none
//! for longer at the beginning of a slide, and large later in it, comes late by at least the excess; at its end, early.

use recording::{ForceRow, PositionRow};
use statistics::quantile;

use crate::cells::{MovingCell, moving_cells, moving_m_per_s};
use crate::implausible::Implausible;
use crate::lateral_evidence::LateralEvidence;

/// Length of a mean of forces, s.
const CELL_S: f64 = 0.02;
/// Time in which the pad is stretched before it slides, s.
const STRETCH_S: f64 = 0.1;
/// Share of the usual greatest lateral force of a slide from which on it is large.
const LARGE: f64 = 0.35;
/// Fewest cells of a slide.
const FEWEST: usize = 20;

/// Returns the finding of a lateral force that begins long after the slides from and to `spans_s`, or ends long before them, under a
/// modulation of the period `period_s`; a finger touches with `contact_n` or more.
pub(crate) fn frictionless_slides(
    (force, position): (&[ForceRow], &[PositionRow]),
    spans_s: &[(f64, f64)],
    (period_s, contact_n): (f64, f64),
) -> Option<Implausible> {
    let start_s = force.first()?.time_s.min(position.first()?.time_s);
    let cells = moving_cells(force, position, CELL_S)?;
    let slides_s: Vec<[f64; 2]> = spans_s
        .iter()
        .filter_map(|(from_s, to_s)| {
            let cell = |time_s: f64| ((time_s - start_s) / CELL_S).max(0.0) as usize;
            let inside = cells.get(cell(*from_s)..cell(*to_s).min(cells.len()))?;
            // Before and after a slide the finger may rest for any time.
            let moving_m_per_s = moving_m_per_s(inside.iter())?;
            let slides = |cell: &&MovingCell| {
                cell.speed_m_per_s.abs() >= moving_m_per_s && cell.force.normal_n >= contact_n
            };
            frictionless_s(&inside.iter().filter(slides).collect::<Vec<_>>())
        })
        .collect();
    [(0, 1.0), (1, -1.0)].into_iter().find_map(|(end, sign)| {
        let excess = slides_s.iter().map(|ends_s| ends_s[end] - period_s);
        let excess_s: Vec<f64> = excess.filter(|excess_s| *excess_s > STRETCH_S).collect();
        // Most slides, as a fingertip may stick in one.
        let late_s = sign * excess_s.iter().copied().reduce(f64::min)?;
        (2 * excess_s.len() > slides_s.len()).then_some(Implausible::LateralLag {
            late_s,
            evidence: LateralEvidence::Slide,
        })
    })
}

/// Returns the times at the beginning and end of a slide without a large lateral force, s.
fn frictionless_s(slide: &[&MovingCell]) -> Option<[f64; 2]> {
    let total_n: f64 = slide.iter().map(|cell| cell.force.lateral_n).sum();
    // Friction of the slide before has the other sign.
    let friction_n = |cell: &&MovingCell| cell.force.lateral_n * total_n.signum();
    let mut sorted_n: Vec<f64> = slide.iter().map(friction_n).collect();
    sorted_n.sort_by(f64::total_cmp);
    let large_n = LARGE * quantile(&sorted_n, 0.95)?;
    let is_large = |cell: &&MovingCell| friction_n(cell) > large_n;
    let (first, last) = (
        slide.iter().position(is_large)?,
        slide.iter().rposition(is_large)?,
    );
    (slide.len() >= FEWEST).then(|| [first, slide.len() - 1 - last].map(|n| n as f64 * CELL_S))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A finger that presses for `duration_s` and slides from 1 to 2.8 s and back from 3 to 4.8 s, under a modulation of 6 Hz; the
    /// lateral force comes `late_s` late.
    fn slid(late_s: f64, duration_s: u32) -> Option<Implausible> {
        let times = (0..1000 * duration_s).map(|n| f64::from(n) * 1e-3);
        let slide = |time_s: f64| match time_s {
            1.0..2.8 => 1.0,
            3.0..4.8 => -1.0,
            _ => 0.0,
        };
        let force: Vec<ForceRow> = { times.clone() }
            .map(|time_s| {
                let then_s = time_s - late_s;
                let share = (TAU * 6.0 * then_s).cos().max(0.0);
                ForceRow {
                    time_s,
                    normal_n: 0.6,
                    lateral_n: 0.4 * slide(then_s) * share + 1e-3 * (7.7 * time_s / 1e-3).sin(),
                }
            })
            .collect();
        let mut position_m = 0.0;
        let position: Vec<PositionRow> = times
            .map(|time_s| {
                position_m += 50e-6 * slide(time_s);
                PositionRow { time_s, position_m }
            })
            .collect();
        // With rests of the finger.
        let spans_s = [(0.5, 2.9), (2.95, 4.9)];
        frictionless_slides((&force, &position), &spans_s, (1.0 / 6.0, 0.1))
    }

    #[test]
    fn a_lateral_force_that_misses_a_period_of_each_slide_is_late_or_early() {
        for late_s in [0.35, 0.5, -0.35, -0.5] {
            let Some(Implausible::LateralLag {
                late_s: found_s,
                evidence: LateralEvidence::Slide,
            }) = slid(late_s, 5)
            else {
                panic!("{late_s} s");
            };
            assert!(found_s * late_s > 0.0 && found_s.abs() <= late_s.abs());
            assert!(
                found_s.abs() > late_s.abs() - 0.25,
                "{late_s} s: {found_s} s"
            );
        }
    }

    #[test]
    fn a_lateral_force_in_time_or_by_less_than_a_period_is_none() {
        for late_s in [0.0, 0.05, -0.05, 0.09, -0.09] {
            for duration_s in [5, 60] {
                assert_eq!(slid(late_s, duration_s), None, "{late_s} s");
            }
        }
        assert_eq!(frictionless_slides((&[], &[]), &[], (0.1, 0.1)), None);
    }
}
