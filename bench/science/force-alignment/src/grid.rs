//! Forces on an even grid.

use impedance::smoothing::LowPass;

use crate::film::ForceSample;

/// Rate of the grid, Hz.
const RATE_HZ: f64 = 2000.0;
/// Cut-off of the low-pass, Hz: friction follows the film within some ms.
const CUTOFF_HZ: f64 = 250.0;
/// Longest grid, s.
const LONGEST_S: f64 = 7200.0;
/// Fewest readings.
const FEWEST: usize = 200;

/// Normal and lateral force at even steps of their stated time, low-passed with zero phase.
#[derive(Debug, Clone)]
pub struct ForceGrid {
    start_s: f64,
    normal: Vec<f64>,
    lateral: Vec<f64>,
}

impl ForceGrid {
    /// Places the finite readings on an even grid; `None` if they are too few.
    #[must_use]
    pub fn new(forces: &[ForceSample]) -> Option<Self> {
        let is_finite =
            |force: &&ForceSample| force.normal.is_finite() && force.lateral.is_finite();
        let forces: Vec<ForceSample> = forces.iter().filter(is_finite).copied().collect();
        let (first, last) = (forces.first()?, forces.last()?);
        let length_s = last.time_s - first.time_s;
        if forces.len() < FEWEST || length_s.is_nan() || length_s > LONGEST_S {
            return None;
        }
        let count = (length_s * RATE_HZ) as usize + 1;
        // Each step takes the mean of its readings, so that a faster sensor has less noise.
        let resample = |value: fn(&ForceSample) -> f64| {
            let mut values = Vec::with_capacity(count);
            let mut next = 0;
            for step in 0..count {
                let time_s = first.time_s + step as f64 / RATE_HZ;
                let end_s = time_s + 0.5 / RATE_HZ;
                let begin = next;
                while next < forces.len() && forces[next].time_s < end_s {
                    next += 1;
                }
                let inside = &forces[begin..next];
                values.push(if inside.is_empty() {
                    let earlier = &forces[next.saturating_sub(1)];
                    let later = &forces[next.min(forces.len() - 1)];
                    let gap_s = later.time_s - earlier.time_s;
                    let share = if gap_s > 0.0 {
                        ((time_s - earlier.time_s) / gap_s).clamp(0.0, 1.0)
                    } else {
                        0.0
                    };
                    value(earlier) + share * (value(later) - value(earlier))
                } else {
                    inside.iter().map(value).sum::<f64>() / inside.len() as f64
                });
            }
            let filter = LowPass::new(CUTOFF_HZ, RATE_HZ).ok()?;
            filter.zero_phase(&values).ok()
        };
        Some(Self {
            start_s: first.time_s,
            normal: resample(|force| force.normal)?,
            lateral: resample(|force| force.lateral)?,
        })
    }

    /// Returns normal and lateral force at a stated time; `None` beyond the readings.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<(f64, f64)> {
        let place = (time_s - self.start_s) * RATE_HZ;
        let index = place.floor();
        if !(index >= 0.0 && index + 1.0 < self.normal.len() as f64) {
            return None;
        }
        let (index, share) = (index as usize, place - index);
        let line = |values: &[f64]| values[index] + share * (values[index + 1] - values[index]);
        Some((line(&self.normal), line(&self.lateral)))
    }
}
