//! Readings of the force sensor in a stretch without a finger: its zero, and its drift.

use std::fmt;

use recording::ForceRow;
use serde::{Deserialize, Serialize};
use statistics::median;

use crate::drift::certain_drift;

/// Length of a mean of forces whose error is independent of the next one's, s: a sensor's noise below 50 Hz is small.
const CELL_S: f64 = 0.02;
/// Fewest blocks of a stretch.
pub const FEWEST_BLOCKS: usize = 2;
/// Fewest blocks that show a drift.
const FEWEST_DRIFTING: usize = 5;
/// Fewest cells of a block with readings.
const FEWEST_CELLS: usize = 3;
/// Largest difference of a block's normal force from its stretch's, N, and in standard errors of the steadiest block if they are
/// larger: a light finger's force is not steady.
const STEADY_N: f64 = 0.002;
const STEADY_ERRORS: f64 = 4.0;
/// Number of standard errors beyond which a change of the zero is certain.
pub const CERTAIN_ERRORS: f64 = 4.0;

/// A value of both axes, N.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Axes {
    /// Normal axis, N.
    pub normal_n: f64,
    /// Lateral axis, N.
    pub lateral_n: f64,
}

impl Axes {
    /// Returns the values that `f` makes of those of both.
    #[must_use]
    pub fn combine(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            normal_n: f(self.normal_n, other.normal_n),
            lateral_n: f(self.lateral_n, other.lateral_n),
        }
    }
}

/// Axis of the force sensor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// Normal to the plate.
    #[default]
    Normal,
    /// Along the slide.
    Lateral,
}

impl Axis {
    /// Returns the value of this axis.
    #[must_use]
    pub fn of(self, axes: Axes) -> f64 {
        match self {
            Self::Normal => axes.normal_n,
            Self::Lateral => axes.lateral_n,
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Normal => "normal",
            Self::Lateral => "lateral",
        })
    }
}

/// Zero in one stretch without a finger.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ZeroReading {
    /// Middle of the stretch, s.
    pub time_s: f64,
    /// Mean of the readings, N.
    #[serde(flatten)]
    pub zero: Axes,
    /// Standard error of the mean, N.
    pub std: Axes,
    /// Drift within the stretch, N/s, where it is larger than its errors.
    #[serde(default, skip_serializing_if = "is_still")]
    pub drift_n_per_s: Axes,
}

fn is_still(drift: &Axes) -> bool {
    *drift == Axes::default()
}

/// A block without a finger.
#[derive(Debug, Clone, Copy)]
pub struct FreeBlock {
    /// Position among all blocks.
    pub index: usize,
    /// Whether it is the last block.
    pub is_last: bool,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// Reads the zero in consecutive free blocks; `None` if there are too few, or if the forces are not a sensor's zero.
#[must_use]
pub fn read_stretch(
    rows: &[ForceRow],
    blocks: &[FreeBlock],
    greatest_n: f64,
) -> Option<ZeroReading> {
    let blocks: Vec<Block> = blocks
        .iter()
        .filter_map(|block| Block::read(rows, block))
        .collect();
    // A steady drift is no finger.
    let steps = blocks
        .windows(2)
        .map(|pair| pair[1].normal_n - pair[0].normal_n);
    let step_n = median(steps)
        .filter(|_| blocks.len() >= FEWEST_DRIFTING)
        .unwrap_or_default();
    let level_n = |(index, block): (usize, &Block)| block.normal_n - step_n * index as f64;
    let typical_n = median(blocks.iter().enumerate().map(level_n))?;
    // Of the steadiest block: while a finger lifts off, its force scatters the most.
    let steady_std_n = blocks.iter().map(|block| block.normal_std_n);
    let limit_n = STEADY_N.max(STEADY_ERRORS * steady_std_n.reduce(f64::min)?);
    let cells: Vec<(f64, Axes)> = blocks
        .iter()
        .enumerate()
        .filter(|&seen| (level_n(seen) - typical_n).abs() <= limit_n)
        .flat_map(|(_, block)| block.cells.iter().copied())
        .collect();
    let n = cells.len() as f64;
    if cells.len() < FEWEST_BLOCKS * FEWEST_CELLS {
        return None;
    }
    let mean_of = |value: &dyn Fn(&(f64, Axes)) -> f64| cells.iter().map(value).sum::<f64>() / n;
    let zero = Axes {
        normal_n: mean_of(&|(_, cell)| cell.normal_n),
        lateral_n: mean_of(&|(_, cell)| cell.lateral_n),
    };
    let std_of = |value: &dyn Fn(&Axes) -> f64| {
        let squares = mean_of(&|(_, cell)| (value(cell) - value(&zero)).powi(2)) * n / (n - 1.0);
        (squares / n).sqrt()
    };
    let all_s = rows.last()?.time_s - rows.first()?.time_s;
    let drift = |axis: Axis| {
        let cells: Vec<(f64, f64)> = cells
            .iter()
            .map(|(time_s, cell)| (*time_s, axis.of(*cell)))
            .collect();
        certain_drift(&cells, all_s).unwrap_or_default()
    };
    let is_plausible = zero.normal_n.abs() <= greatest_n;
    is_plausible.then(|| ZeroReading {
        time_s: mean_of(&|(time_s, _)| *time_s),
        zero,
        std: Axes {
            normal_n: std_of(&|cell| cell.normal_n),
            lateral_n: std_of(&|cell| cell.lateral_n),
        },
        drift_n_per_s: Axes {
            normal_n: drift(Axis::Normal),
            lateral_n: drift(Axis::Lateral),
        },
    })
}

/// Forces of a block without a finger.
struct Block {
    /// Middle, s, and mean of each cell.
    cells: Vec<(f64, Axes)>,
    normal_n: f64,
    /// Standard error of `normal_n`, N.
    normal_std_n: f64,
}

impl Block {
    /// Reads a block; `None` if too few of its cells have readings.
    fn read(rows: &[ForceRow], block: &FreeBlock) -> Option<Self> {
        let count = ((block.end_s - block.start_s) / CELL_S).round().max(1.0);
        let length_s = (block.end_s - block.start_s) / count;
        let cells = (0..count as u32).filter_map(|cell| {
            let start_s = block.start_s + f64::from(cell) * length_s;
            let mean = mean_force(rows, (start_s, start_s + length_s))?;
            Some((start_s + length_s / 2.0, mean))
        });
        let cells: Vec<(f64, Axes)> = cells.collect();
        if cells.len() < FEWEST_CELLS {
            return None;
        }
        let n = cells.len() as f64;
        let normal_n = cells.iter().map(|(_, cell)| cell.normal_n).sum::<f64>() / n;
        let squares = cells
            .iter()
            .map(|(_, cell)| (cell.normal_n - normal_n).powi(2));
        Some(Self {
            normal_n,
            normal_std_n: (squares.sum::<f64>() / (n - 1.0) / n).sqrt(),
            cells,
        })
    }
}

/// Returns the mean of the finite readings in a span, N.
#[must_use]
pub fn mean_force(rows: &[ForceRow], (start_s, end_s): (f64, f64)) -> Option<Axes> {
    let start = rows.partition_point(|row| row.time_s < start_s);
    let end = rows.partition_point(|row| row.time_s < end_s).max(start);
    let is_finite = |row: &&ForceRow| row.normal_n.is_finite() && row.lateral_n.is_finite();
    let finite_rows = || rows[start..end].iter().filter(is_finite);
    let n = finite_rows().count() as f64;
    (n > 0.0).then(|| Axes {
        normal_n: finite_rows().map(|row| row.normal_n).sum::<f64>() / n,
        lateral_n: finite_rows().map(|row| row.lateral_n).sum::<f64>() / n,
    })
}
