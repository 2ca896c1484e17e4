//! Zero of the lateral force by strokes there and back.
//!
//! Friction opposes the slide: at equal speed its mean over both directions is 0. It is least where the film lifts the finger,
//! once in each period of the modulation, and there an error of the assumption is least. With q the lateral force that only a tenth
//! of a period's readings come closer to the other direction's, the zero is (q_there + q_back)/2. A crosstalk of the normal force
//! acts as a zero.

use statistics::{median, quantile};

use crate::film::{Estimate, ForceSample};
use crate::grid::ForceGrid;

/// Share of a period's readings beyond the one that is taken.
const LIFTED: f64 = 0.1;
/// Share of a slide at each end that is left out.
const END_SHARE: f64 = 0.1;
/// Step of the readings, s.
const STEP_S: f64 = 1e-3;
/// Fewest periods of each direction.
const FEWEST: usize = 3;

/// Stroke of a finger over the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Whether the position grows.
    pub grows: bool,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// Returns the zero of the lateral force by strokes in both directions, in its unit; `None` without both.
#[must_use]
pub fn lateral_zero(
    forces: &[ForceSample],
    strokes: &[Stroke],
    modulation_hz: f64,
) -> Option<Estimate> {
    let grid = ForceGrid::new(forces)?;
    let [there, back] = [true, false].map(|grows| {
        let strokes = strokes.iter().filter(|stroke| stroke.grows == grows);
        strokes
            .flat_map(|stroke| periods(&grid, stroke, modulation_hz))
            .collect::<Vec<_>>()
    });
    if there.len().min(back.len()) < FEWEST {
        return None;
    }
    let middle = |periods: &[Vec<f64>]| median(periods.iter().flatten().copied());
    let is_forward = middle(&there)? > middle(&back)?;
    let lifted = |periods: &[Vec<f64>], is_low: bool| -> Option<Estimate> {
        let share = if is_low { LIFTED } else { 1.0 - LIFTED };
        let values: Option<Vec<f64>> = periods
            .iter()
            .map(|period| quantile(period, share))
            .collect();
        let values = values?;
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|sample| (sample - value).powi(2)).sum();
        Some(Estimate {
            value,
            std: (squares / (n - 1.0) / n).sqrt(),
        })
    };
    let (there, back) = (lifted(&there, is_forward)?, lifted(&back, !is_forward)?);
    Some(Estimate {
        value: 0.5 * (there.value + back.value),
        std: 0.5 * there.std.hypot(back.std),
    })
}

/// Returns the sorted lateral forces of each whole period of the modulation in a stroke.
fn periods(grid: &ForceGrid, stroke: &Stroke, modulation_hz: f64) -> Vec<Vec<f64>> {
    let margin_s = END_SHARE * (stroke.end_s - stroke.start_s);
    let period_s = modulation_hz.recip();
    let count = ((stroke.end_s - stroke.start_s - 2.0 * margin_s) / period_s)
        .floor()
        .max(0.0) as u32;
    let steps = (period_s / STEP_S).round() as u32;
    let period = |index: u32| {
        let start_s = stroke.start_s + margin_s + f64::from(index) * period_s;
        let readings = (0..steps).filter_map(|step| grid.at(start_s + f64::from(step) * STEP_S));
        let mut readings: Vec<f64> = readings.map(|(_, lateral)| lateral).collect();
        readings.sort_by(f64::total_cmp);
        readings
    };
    (0..count)
        .map(period)
        .filter(|period| !period.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn strokes_there_and_back_show_the_zero() {
        for (zero, sign) in [(0.0, 1.0), (0.1, 1.0), (-0.3, -1.0)] {
            let force = |step: i32| {
                let time_s = f64::from(step) * 5e-4;
                let slide = if time_s < 2.0 { sign } else { -0.95 * sign };
                let friction = 0.35 * (1.0 + (TAU * 6.0 * time_s).sin());
                let noise = 0.005 * (f64::from(step) * 2.399).sin();
                ForceSample {
                    time_s,
                    normal: 0.6,
                    lateral: 0.6 * slide * friction + zero + noise,
                }
            };
            let forces: Vec<ForceSample> = (0..8000).map(force).collect();
            let stroke = |grows, start_s, end_s| Stroke {
                grows,
                start_s,
                end_s,
            };
            let strokes = [stroke(true, 0.1, 1.9), stroke(false, 2.1, 3.9)];
            let found = lateral_zero(&forces, &strokes, 6.0).unwrap();
            assert!((found.value - zero).abs() < 0.003, "{zero}: {found:?}");
            assert_eq!(lateral_zero(&forces, &strokes[..1], 6.0), None);
        }
    }
}
