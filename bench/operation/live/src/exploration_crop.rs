//! Crop of an exploration for the operator's screen.

use analysis::measurements::FrameSeries;
use protocols::{Direction, Stretch, TrialLabel, Validity};
use tui::event::{Crop, CropStretch};

/// Number of cells of the crop's curves: more than the dots that a terminal has for one of two explorations side by side.
const CELLS: usize = 200;

/// Identification of a cropped exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExplorationName {
    /// Attempt at its trial.
    pub attempt: TrialLabel,
    /// Number of the exploration within the trial, from 1.
    pub exploration: u32,
}

/// Returns the crop of an exploration from `start_s` to `end_s`: the smallest and the largest amplitude of each cell, and means
/// of the other signals.
pub fn crop(
    name: ExplorationName,
    direction: Direction,
    (start_s, end_s): (f64, f64),
    series: &FrameSeries,
    stretches: &[Stretch],
) -> Crop {
    let duration_s = end_s - start_s;
    let edge = |cell: usize| {
        let at_s = start_s + duration_s * cell as f64 / CELLS as f64;
        series.time_s.partition_point(|time_s| *time_s < at_s)
    };
    let cells: Vec<_> = (0..CELLS).map(|cell| edge(cell)..edge(cell + 1)).collect();
    let mean = |values: &[f64], sign: f64| -> Vec<Option<f64>> {
        let cell_mean = |cell: &std::ops::Range<usize>| {
            let finite = values[cell.clone()].iter().filter(|v| v.is_finite());
            let (sum, count) = finite.fold((0.0, 0u32), |(sum, count), v| (sum + v, count + 1));
            (count > 0).then(|| sign * sum / f64::from(count))
        };
        cells.iter().map(cell_mean).collect()
    };
    let extent = |cell: &std::ops::Range<usize>| {
        let usable = cell
            .clone()
            .filter(|i| series.validity[*i] != Validity::LostSamples)
            .map(|i| series.amplitude_m[i])
            .filter(|amplitude_m| amplitude_m.is_finite());
        usable.fold(None, |extent: Option<(f64, f64)>, a| {
            Some(extent.map_or((a, a), |(low, high)| (low.min(a), high.max(a))))
        })
    };
    Crop {
        trial: name.attempt.number,
        practice: name.attempt.is_practice(),
        attempt: name.attempt.attempt,
        exploration: name.exploration,
        leftwards: direction == Direction::RightToLeft,
        start_s,
        duration_s,
        amplitude_m: cells.iter().map(extent).collect(),
        normal_n: mean(&series.normal_n, 1.0),
        lateral_n: mean(&series.lateral_n, 1.0),
        position_m: mean(&series.position_m, 1.0),
        speed_m_per_s: mean(&series.velocity_m_per_s, direction.sign()),
        stretches: stretches
            .iter()
            .map(|stretch| {
                let instance = stretch.instance();
                let rejection = stretch.rejection();
                CropStretch {
                    start_s: instance.map_or(stretch.start_s, |instance| instance.start_s)
                        - start_s,
                    end_s: instance.map_or(stretch.end_s, |instance| instance.end_s) - start_s,
                    accepted: instance.is_some(),
                    reason: rejection.map(|rejection| rejection.to_string()),
                    kind: rejection.map(|rejection| rejection.kind().to_owned()),
                }
            })
            .collect(),
    }
}
