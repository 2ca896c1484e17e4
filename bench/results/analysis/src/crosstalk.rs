//! Crosstalk from the normal to the lateral force, as a recording shows it.
//!
//! Friction acts against the slide, so that f_t/f_n = ±μ + κ for slides forth and back, with the crosstalk κ in both. The film
//! lifts the finger once in every period of the modulation; there μ is smallest, and so is the difference between the
//! directions' friction. With q the ratio f_t/f_n at that level, κ = (q_forth + q_back)/2. A recording of one direction shows κ
//! only where f_t reverses: a friction below zero.

use statistics::{median, quantile};

use crate::measurements::Measurements;
use plausibility::zero_stretch::mean_force;
use protocols::{Direction, SelectionRules};

/// Length of a mean of forces, s: short compared with a period of the modulation, and many readings.
const CELL_S: f64 = 0.01;
/// Share of the cells of an exploration in which friction is lower than at the level that is read.
const LEVITATED: f64 = 0.05;
/// Fewest cells of an exploration.
const FEWEST_CELLS: usize = 40;

/// Crosstalk that a recording shows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SeenCrosstalk {
    /// Lateral force per newton of normal force that does not turn with the slide; 0 if none is seen.
    pub(crate) per_normal: f64,
    /// Whether the crosstalk cannot be much larger: slides of one direction show only a part of it.
    pub(crate) is_bounded: bool,
}

/// Returns the crosstalk by explorations, each as direction, start and end, s.
pub(super) fn seen(
    record: &Measurements,
    explorations: &[(Direction, f64, f64)],
    rules: &SelectionRules,
) -> SeenCrosstalk {
    let slides = explorations
        .iter()
        .filter_map(|&(direction, start_s, end_s)| {
            let ratios = ratios(record, (start_s, end_s), rules);
            let forward = if direction == Direction::LeftToRight {
                1.0
            } else {
                -1.0
            };
            let middle = median(ratios.iter().copied()).filter(|_| ratios.len() >= FEWEST_CELLS)?;
            Some((forward, middle, ratios))
        });
    let slides: Vec<(f64, f64, Vec<f64>)> = slides.collect();
    // The sensor's sign is that of the friction in most slides.
    let sign: f64 = slides
        .iter()
        .map(|(forward, middle, _)| forward * middle)
        .sum();
    let lowest = |way: f64| -> Option<f64> {
        let inside = slides.iter().filter(|slide| slide.0 * sign.signum() == way);
        let lowest = inside.filter_map(|(_, _, ratios)| {
            let mut friction: Vec<f64> = ratios.iter().map(|ratio| ratio * way).collect();
            friction.sort_by(f64::total_cmp);
            quantile(&friction, LEVITATED)
        });
        let lowest: Vec<f64> = lowest.collect();
        (!lowest.is_empty()).then(|| lowest.iter().sum::<f64>() / lowest.len() as f64)
    };
    match (lowest(1.0), lowest(-1.0)) {
        (Some(forth), Some(back)) => SeenCrosstalk {
            per_normal: 0.5 * (forth - back).abs(),
            is_bounded: true,
        },
        (Some(friction), None) | (None, Some(friction)) => SeenCrosstalk {
            per_normal: (-friction).max(0.0),
            is_bounded: false,
        },
        (None, None) => SeenCrosstalk::default(),
    }
}

/// Returns f_t/f_n in each cell of a span in which the finger slides over the plate's central part.
fn ratios(record: &Measurements, (start_s, end_s): (f64, f64), rules: &SelectionRules) -> Vec<f64> {
    let is_central = |time_s: f64| {
        let position_m = record.position_m(time_s);
        position_m.is_some_and(|x| (x - rules.centre_m).abs() <= 0.5 * rules.central_m)
    };
    (0..((end_s - start_s) / CELL_S) as u32)
        .map(|cell| start_s + f64::from(cell) * CELL_S)
        .filter(|cell_s| is_central(*cell_s) && is_central(cell_s + CELL_S))
        .filter_map(|cell_s| mean_force(&record.force, (cell_s, cell_s + CELL_S)))
        .filter(|force| force.normal_n >= rules.contact_n)
        .map(|force| force.lateral_n / force.normal_n)
        .collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;
    use recording::PositionRow;

    use super::*;
    use crate::analysis_settings::Settings;
    use crate::tests::measured;

    /// A finger of 0.6 N that slides forth over 100 mm in the first two seconds and back in the next two, at rest at both ends,
    /// with friction of 0.1 to 0.8 at 6 Hz.
    fn record(crosstalk: f64) -> Measurements {
        let position_m = |time_s: f64| {
            let way_s = if time_s < 2.0 { time_s } else { 4.0 - time_s };
            0.05 * way_s
        };
        let force = |time_s: f64| {
            let friction = 0.45 + 0.35 * (std::f64::consts::TAU * 6.0 * time_s).sin();
            let slide = if time_s < 2.0 { 1.0 } else { -1.0 };
            let is_sliding = (0.01..0.09).contains(&position_m(time_s));
            let friction = if is_sliding { slide * friction } else { 0.0 };
            (0.6, 0.6 * (friction + crosstalk))
        };
        let mut record = measured(4.0, |_| Complex64::ONE, force);
        let rows = record.force.iter().map(|row| PositionRow {
            time_s: row.time_s,
            position_m: position_m(row.time_s),
        });
        record.position = rows.collect();
        record
    }

    const FORTH: (Direction, f64, f64) = (Direction::LeftToRight, 0.0, 2.0);
    const BACK: (Direction, f64, f64) = (Direction::RightToLeft, 2.0, 4.0);

    fn rules() -> SelectionRules {
        Settings::default().selection_rules(0.05)
    }

    #[test]
    fn slides_forth_and_back_show_the_crosstalk() {
        for crosstalk in [0.0, 0.03, -0.03, 0.2, -0.2] {
            let seen = seen(&record(crosstalk), &[FORTH, BACK], &rules());
            let difference = (seen.per_normal - crosstalk.abs()).abs();
            assert!(
                difference < 1e-3 && seen.is_bounded,
                "{crosstalk}: {seen:?}"
            );
        }
    }

    #[test]
    fn a_slide_of_one_direction_shows_only_a_reversed_force() {
        for (crosstalk, span, expected) in [
            (0.03, FORTH, 0.0),
            (-0.15, FORTH, 0.045),
            (0.15, BACK, 0.045),
        ] {
            let seen = seen(&record(crosstalk), &[span], &rules());
            let difference = (seen.per_normal - expected).abs();
            assert!(
                difference < 0.01 && !seen.is_bounded,
                "{crosstalk}: {seen:?}"
            );
        }
        assert_eq!(seen(&record(0.03), &[], &rules()), SeenCrosstalk::default());
    }
}
