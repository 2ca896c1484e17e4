//! Columns of the forces that are exchanged or alike, by strokes there and back.
//!
//! Friction opposes the motion, so that the lateral force turns with the direction of the stroke; the normal force does not. With the
//! means of a column over the strokes of either direction, m₊ and m₋:
//!
//! ```text
//! turn = (m₊ − m₋)/2,    press = (m₊ + m₋)/2
//! ```

use recording::ForceRow;

use crate::Implausible;
use crate::motion::Slide;

/// Smallest ratio of the turns of both columns, and of press and turn of the pressing one.
const CLEAR: f64 = 3.0;
/// Smallest turn of a lateral force, as a share of its press: a zero that is off makes a press of it.
const LEAST_TURN: f64 = 0.5;
/// Ratio of the larger of turn and press to the smaller one from which on the signs of all strokes are certain; least of both, N.
const CERTAIN: f64 = 1.5;
const LEAST_N: f64 = 0.02;
/// Fewest readings that are compared.
const FEWEST: usize = 50;

/// Returns the flaw of columns that are equal in each row, or exchanged; `None` also without strokes in both directions.
#[must_use]
pub fn mixed_columns(rows: &[ForceRow], slides: &[Slide]) -> Option<Implausible> {
    let is_varying = rows
        .windows(2)
        .any(|pair| pair[0].normal_n != pair[1].normal_n);
    let are_alike = |row: &ForceRow| row.normal_n.to_bits() == row.lateral_n.to_bits();
    if rows.len() >= FEWEST && is_varying && rows.iter().all(are_alike) {
        return Some(Implausible::Alike);
    }
    let normal = Turn::read(rows, slides, |row| row.normal_n)?;
    let lateral = Turn::read(rows, slides, |row| row.lateral_n)?;
    let is_likelier = normal.turn_n > CLEAR * lateral.turn_n
        && normal.turn_n > LEAST_TURN * normal.press_n
        && lateral.press_n > CLEAR * lateral.turn_n;
    // A normal force pushes in both directions, and the force that turns is friction.
    let is_certain = normal.turn_n > CERTAIN * normal.press_n
        && lateral.press_n > CERTAIN * lateral.turn_n
        && normal.turn_n.min(lateral.press_n) > LEAST_N;
    let is_exchanged = normal.is_separated && (is_likelier || is_certain);
    is_exchanged.then_some(Implausible::ExchangedByStrokes {
        turn_n: normal.turn_n,
        press_n: lateral.press_n,
    })
}

/// How a column changes with the direction of the strokes.
struct Turn {
    turn_n: f64,
    press_n: f64,
    /// Whether all strokes of one direction are above all of the other.
    is_separated: bool,
}

impl Turn {
    fn read(rows: &[ForceRow], slides: &[Slide], value: fn(&ForceRow) -> f64) -> Option<Self> {
        let mean = |slide: &Slide| {
            let (start_s, end_s) = slide.middle_s();
            let start = rows.partition_point(|row| row.time_s < start_s);
            let end = rows.partition_point(|row| row.time_s <= end_s);
            let inside = rows.get(start..end).unwrap_or_default().iter();
            let values: Vec<f64> = inside
                .map(value)
                .filter(|value| value.is_finite())
                .collect();
            (values.len() >= FEWEST).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let means = |grows: bool| -> Vec<f64> {
            let slides = slides.iter().filter(|slide| slide.grows == grows);
            slides.filter_map(mean).collect()
        };
        let [there, back] = [means(true), means(false)];
        let middle = |means: &[f64]| {
            (!means.is_empty()).then(|| means.iter().sum::<f64>() / means.len() as f64)
        };
        let (plus_n, minus_n) = (middle(&there)?, middle(&back)?);
        let least = |means: &[f64]| means.iter().copied().fold(f64::INFINITY, f64::min);
        let most = |means: &[f64]| means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            turn_n: 0.5 * (plus_n - minus_n).abs(),
            press_n: 0.5 * (plus_n + minus_n).abs(),
            is_separated: least(&there) > most(&back) || least(&back) > most(&there),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces of strokes to and fro of 1 s, with these presses, N, and a friction coefficient.
    fn rows(press_n: [f64; 2], mu: f64, swapped: bool) -> (Vec<ForceRow>, Vec<Slide>) {
        let slide = |number: u32| Slide {
            grows: number.is_multiple_of(2),
            start_s: f64::from(number),
            end_s: f64::from(number) + 1.0,
        };
        let row = |step: u32| {
            let side = (step / 1000 % 2) as usize;
            let time_s = 1e-3 * f64::from(step);
            let normal_n = press_n[side] + 0.02 * (20.0 * time_s).sin();
            let lateral_n = if side == 0 { -mu } else { mu } * normal_n;
            let (normal_n, lateral_n) = if swapped {
                (lateral_n, normal_n)
            } else {
                (normal_n, lateral_n)
            };
            ForceRow {
                time_s,
                normal_n,
                lateral_n,
            }
        };
        ((0..4000).map(row).collect(), (0..4).map(slide).collect())
    }

    #[test]
    fn exchanged_columns_are_found_by_strokes_there_and_back() {
        for mu in [0.05, 0.3, 0.8, 1.5] {
            for press_n in [[0.6, 0.6], [0.5, 0.7], [0.3, 0.9]] {
                let (stated, slides) = rows(press_n, mu, false);
                assert_eq!(mixed_columns(&stated, &slides), None, "{mu} {press_n:?}");
                let (swapped, slides) = rows(press_n, mu, true);
                let found = mixed_columns(&swapped, &slides);
                assert!(
                    matches!(found, Some(Implausible::ExchangedByStrokes { .. })),
                    "{mu} {press_n:?} {found:?}"
                );
                assert_eq!(mixed_columns(&swapped, &slides[..1]), None);
            }
        }
    }

    #[test]
    fn a_column_read_twice_is_found() {
        let (mut forces, slides) = rows([0.6, 0.6], 0.5, false);
        for row in &mut forces {
            row.lateral_n = row.normal_n;
        }
        assert_eq!(mixed_columns(&forces, &slides), Some(Implausible::Alike));
        // A dead sensor is another flaw.
        for row in &mut forces {
            (row.normal_n, row.lateral_n) = (0.0, 0.0);
        }
        assert_eq!(mixed_columns(&forces, &slides), None);
    }
}
