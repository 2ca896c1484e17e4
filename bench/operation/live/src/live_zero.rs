//! Zero of the force sensor while the bench runs: its usual reading while no finger is on the plate.

use std::collections::VecDeque;

use impedance::ZmFrame;
use num_complex::Complex64;
use recording::ForceRow;
use statistics::median;

use analysis::force_zero::{Axes, FOLLOWED, FREE_N_S_PER_M, GREATEST_ZERO_N};

/// Length of a block, s.
const BLOCK_S: f64 = 0.1;
/// Number of blocks of the median: a finger may rest on the plate for half of their 3 s, too lightly for the impedance to show.
const BLOCKS: usize = 30;

/// Zero of the force sensor from its newest readings without a finger: where the force is small, and the impedance that of the
/// free plate, as in an analysis.
///
/// A block of 0.1 s counts once the next one is over without a finger too: a finger that lands rests on the plate before its
/// force shows it.
#[derive(Debug, Default)]
pub(crate) struct LiveZero {
    blocks: VecDeque<Axes>,
    last_block: Option<Axes>,
    block: Option<Block>,
    /// Impedance of the free plate in this stretch, N·s/m: followed from that at its beginning.
    z_p: Option<Complex64>,
}

/// Block in progress.
#[derive(Debug)]
struct Block {
    start_s: f64,
    force: Axes,
    readings: f64,
    /// Σ|x̃_p|² Z_m and Σ|x̃_p|².
    impedance: Complex64,
    weights: f64,
}

impl LiveZero {
    /// Takes the readings of a frame with a force that shows no finger, on a plate known to have the impedance `z_p`, N·s/m.
    pub(crate) fn take_free(&mut self, row: &ForceRow, frame: &ZmFrame, z_p: Option<Complex64>) {
        let block = self.block.get_or_insert(Block {
            start_s: row.time_s,
            force: Axes::default(),
            readings: 0.0,
            impedance: Complex64::ZERO,
            weights: 0.0,
        });
        block.force.normal_n += row.normal_n;
        block.force.lateral_n += row.lateral_n;
        block.readings += 1.0;
        if frame.mask.is_clear() {
            let weight = frame.amplitude_m.powi(2);
            block.impedance += frame.corrected_n_s_per_m * weight;
            block.weights += weight;
        }
        if row.time_s - block.start_s >= BLOCK_S
            && let Some(block) = self.block.take()
        {
            self.end(&block, z_p);
        }
    }

    fn end(&mut self, block: &Block, z_p: Option<Complex64>) {
        let z_m = block.impedance / block.weights;
        let free_plate = self.z_p.or(z_p);
        // Not so either where the impedance was not measured.
        let is_free = free_plate.is_some_and(|z_p| (z_m - z_p).norm() <= FREE_N_S_PER_M);
        if !is_free {
            self.last_block = None;
            return;
        }
        self.z_p = free_plate.map(|z_p| z_p + FOLLOWED * (z_m - z_p));
        let mean = Axes {
            normal_n: block.force.normal_n / block.readings,
            lateral_n: block.force.lateral_n / block.readings,
        };
        if let Some(settled) = self.last_block.replace(mean) {
            self.blocks.push_back(settled);
            if self.blocks.len() > BLOCKS {
                self.blocks.pop_front();
            }
        }
    }

    /// Takes a reading under a finger, or after missing ones.
    pub(crate) fn interrupt(&mut self) {
        (self.last_block, self.block, self.z_p) = (None, None, None);
    }

    /// Returns the zero, N; 0 before it was read, and while it is larger than a sensor's zero may be.
    pub(crate) fn zero(&self) -> Axes {
        let middle = |axis: fn(&Axes) -> f64| median(self.blocks.iter().map(axis));
        let normal_n = middle(|block| block.normal_n);
        let zero = normal_n.zip(middle(|block| block.lateral_n));
        // NaN is not plausible either.
        let is_plausible = |zero_n: f64| zero_n.abs() <= GREATEST_ZERO_N;
        match zero {
            Some((normal_n, lateral_n)) if is_plausible(normal_n) && is_plausible(lateral_n) => {
                Axes {
                    normal_n,
                    lateral_n,
                }
            }
            _ => Axes::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use impedance::Mask;

    use super::*;
    use crate::tests::frame;

    const PLATE: Complex64 = Complex64::new(7.0, 0.2);

    /// Takes frames with the forces (normal, lateral) and a finger's impedance, one a millisecond.
    fn take(
        zero: &mut LiveZero,
        millis: std::ops::Range<u32>,
        forces_n: (f64, f64),
        finger: Complex64,
    ) {
        for i in millis {
            let row = ForceRow {
                time_s: f64::from(i) * 1e-3,
                normal_n: forces_n.0,
                lateral_n: forces_n.1,
            };
            zero.take_free(&row, &frame(0, row.time_s, PLATE + finger), Some(PLATE));
        }
    }

    fn assert_zero(zero: &LiveZero, normal_n: f64) {
        let read = zero.zero();
        assert!((read.normal_n - normal_n).abs() < 1e-12, "{read:?}");
        assert!((read.lateral_n + normal_n).abs() < 1e-12, "{read:?}");
    }

    #[test]
    fn the_zero_is_read_without_a_finger_and_not_from_its_landing() {
        let mut zero = LiveZero::default();
        take(&mut zero, 0..300, (0.03, -0.03), Complex64::ZERO);
        // A finger lands lightly.
        take(&mut zero, 300..390, (0.048, -0.048), Complex64::ZERO);
        zero.interrupt();
        assert_zero(&zero, 0.03);
    }

    /// Regression test: a finger of less than half the contact force was the zero after a second, 0.07 N here.
    #[test]
    fn a_finger_that_rests_for_a_second_is_not_part_of_the_zero() {
        let mut zero = LiveZero::default();
        take(&mut zero, 0..2000, (0.03, -0.03), Complex64::ZERO);
        take(&mut zero, 2000..3000, (0.07, -0.07), Complex64::ZERO);
        assert_zero(&zero, 0.03);
        // A sensor that was knocked is followed.
        take(&mut zero, 3000..5000, (0.04, -0.04), Complex64::ZERO);
        assert_zero(&zero, 0.04);
    }

    /// Regression test: with a negative zero, a finger of 0.15 N is below half the contact force.
    #[test]
    fn a_finger_that_the_impedance_shows_is_not_part_of_the_zero() {
        let mut zero = LiveZero::default();
        take(&mut zero, 0..1000, (-0.12, 0.12), Complex64::ZERO);
        let finger = Complex64::new(0.13, -0.36);
        take(&mut zero, 1000..9000, (0.03, -0.03), finger);
        assert_zero(&zero, -0.12);
        // A plate that cools is followed.
        for i in 0..20 {
            let drift = Complex64::new(0.0, 0.03 * f64::from(i));
            let millis = (9 + i) * 1000..(10 + i) * 1000;
            take(&mut zero, millis, (-0.11, 0.11), drift);
        }
        assert_zero(&zero, -0.11);
    }

    #[test]
    fn without_a_known_plate_or_an_impedance_there_is_no_zero() {
        for (mask, z_p) in [(Mask::CLEAR, None), (Mask::LOST_SAMPLES, Some(PLATE))] {
            let mut zero = LiveZero::default();
            for i in 0..1000 {
                let row = ForceRow {
                    time_s: f64::from(i) * 1e-3,
                    normal_n: 0.03,
                    lateral_n: -0.03,
                };
                let frame = ZmFrame {
                    mask,
                    ..frame(0, row.time_s, PLATE)
                };
                zero.take_free(&row, &frame, z_p);
            }
            assert_eq!(zero.zero(), Axes::default());
        }
    }

    #[test]
    fn an_axis_without_readings_has_no_zero() {
        let mut zero = LiveZero::default();
        take(&mut zero, 0..1000, (0.03, f64::NAN), Complex64::ZERO);
        assert_eq!(zero.zero(), Axes::default());
    }

    #[test]
    fn a_weight_on_the_plate_is_no_zero() {
        let mut zero = LiveZero::default();
        take(&mut zero, 0..1000, (0.3, -0.3), Complex64::ZERO);
        assert_eq!(zero.zero(), Axes::default());
    }
}
