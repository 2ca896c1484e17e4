//! Zero of the force sensor while the bench runs: the mean of its readings while no finger is on the plate.

use std::collections::VecDeque;

use recording::ForceRow;

use analysis::force_zero::Axes;

/// Length of a block, s.
const BLOCK_S: f64 = 0.1;
/// Number of blocks of the mean: a second.
const BLOCKS: usize = 10;
/// Largest zero of an axis that is used, N, as in an analysis.
const GREATEST_ZERO_N: f64 = 0.15;

/// Zero of the force sensor from its newest readings without a finger.
///
/// A block of 0.1 s counts once the next one is over without a finger too: a finger that lands rests on the plate before its
/// force shows it.
#[derive(Debug, Default)]
pub(crate) struct LiveZero {
    blocks: VecDeque<Axes>,
    last_block: Option<Axes>,
    /// Start, sum and number of readings of the block in progress.
    begun: Option<(f64, Axes, f64)>,
}

impl LiveZero {
    /// Takes a reading without a finger.
    pub(crate) fn take_free(&mut self, row: &ForceRow) {
        let (start_s, sum, n) = self.begun.unwrap_or((row.time_s, Axes::default(), 0.0));
        let sum = Axes {
            normal_n: sum.normal_n + row.normal_n,
            lateral_n: sum.lateral_n + row.lateral_n,
        };
        self.begun = Some((start_s, sum, n + 1.0));
        if row.time_s - start_s < BLOCK_S {
            return;
        }
        self.begun = None;
        let block = Axes {
            normal_n: sum.normal_n / (n + 1.0),
            lateral_n: sum.lateral_n / (n + 1.0),
        };
        if let Some(settled) = self.last_block.replace(block) {
            self.blocks.push_back(settled);
            if self.blocks.len() > BLOCKS {
                self.blocks.pop_front();
            }
        }
    }

    /// Takes a reading under a finger, or after missing ones.
    pub(crate) fn interrupt(&mut self) {
        (self.last_block, self.begun) = (None, None);
    }

    /// Returns the zero, N; 0 before it was read, and while it is larger than a sensor's zero may be.
    pub(crate) fn zero(&self) -> Axes {
        let n = self.blocks.len().max(1) as f64;
        let mean = |axis: fn(&Axes) -> f64| self.blocks.iter().map(axis).sum::<f64>() / n;
        let zero = Axes {
            normal_n: mean(|block| block.normal_n),
            lateral_n: mean(|block| block.lateral_n),
        };
        let is_plausible = |zero_n: f64| zero_n.abs() <= GREATEST_ZERO_N;
        // Also false for NaN.
        if is_plausible(zero.normal_n) && is_plausible(zero.lateral_n) {
            zero
        } else {
            Axes::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(time_s: f64, normal_n: f64) -> ForceRow {
        ForceRow {
            time_s,
            normal_n,
            lateral_n: -normal_n,
        }
    }

    #[test]
    fn the_zero_is_the_mean_without_a_finger_and_not_of_its_landing() {
        let mut zero = LiveZero::default();
        for i in 0..1000 {
            zero.take_free(&row(f64::from(i) * 1e-3, 0.03));
        }
        // A finger lands lightly.
        for i in 1000..1090 {
            zero.take_free(&row(f64::from(i) * 1e-3, 0.048));
        }
        zero.interrupt();
        assert!((zero.zero().normal_n - 0.03).abs() < 1e-12);
        assert!((zero.zero().lateral_n + 0.03).abs() < 1e-12);
    }

    #[test]
    fn an_axis_without_readings_has_no_zero() {
        let mut zero = LiveZero::default();
        for i in 0..1000 {
            let lateral_n = if i < 500 { f64::NAN } else { 0.01 };
            zero.take_free(&ForceRow {
                lateral_n,
                ..row(f64::from(i) * 1e-3, 0.03)
            });
        }
        assert_eq!(zero.zero(), Axes::default());
    }

    #[test]
    fn a_weight_on_the_plate_is_no_zero() {
        let mut zero = LiveZero::default();
        for i in 0..1000 {
            zero.take_free(&row(f64::from(i) * 1e-3, 0.3));
        }
        assert_eq!(zero.zero(), Axes::default());
    }
}
