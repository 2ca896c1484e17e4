//! What is known of the plate at an instance from where no finger was on it.

use std::ops::RangeInclusive;

use num_complex::Complex64;

use super::prior::{Normal, TrialPriors};

/// The plate's impedance where no finger was on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateReference {
    /// Time, s.
    pub time_s: f64,
    /// Z_p, N·s/m.
    pub z_p_n_s_per_m: Complex64,
    /// Standard error of each of its parts, N·s/m.
    pub std_n_s_per_m: f64,
}

/// Bend of what warms under a finger between two references, as a part of the change between them (an assumption): a
/// first-order warming has 0.03 of it where the time between them is a quarter of its time constant, 0.12 where it is equal.
const BEND: Normal = Normal {
    mean: 0.05,
    std: 0.07,
};
/// Standard deviation of the damping's bend about that of the resonance, which the same temperature moves.
const ASTRAY: f64 = 0.025;
/// Change of the reactance that a finger may make and take back within an exploration, N·s/m: ten hertz of a plate of 8 g.
const REACTANCE_CHANGE_N_S_PER_M: f64 = 1.0;
/// Change of the reactance from which its course can be told, N·s/m: half a hertz.
const COURSE_N_S_PER_M: f64 = 0.05;
/// Bends that one warming or one room can make; others are two that nearly cancel, and tell nothing of the damping.
const BELIEVED: RangeInclusive<f64> = -0.05..=0.2;
/// Departure of an instance's damping from the course of all, N·s/m.
const LEAST_STD_N_S_PER_M: f64 = 2e-4;

/// What references tell of the plate's offset at an instance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OffsetPrior {
    /// Offset on a straight line between the references; 0 without.
    pub(super) mean: Complex64,
    /// By how much the bend moves the damping, N·s/m.
    pub(super) damping_by_bend: f64,
    /// Standard deviation of the reactance's offset about its mean, N·s/m.
    pub(super) reactance_std: f64,
    /// Standard deviation of the damping's offset about its course, N·s/m; `None` where no reference follows: nothing then
    /// tells a damping that changed from one that did not.
    pub(super) damping_std: Option<f64>,
    /// By how much a bend would move the reactance, N·s/m.
    reactance_by_bend: f64,
}

impl OffsetPrior {
    /// Returns the prior at a time, as offset from the plate of the unloaded interval.
    pub(super) fn at(
        time_s: f64,
        references: &[PlateReference],
        z_p: Complex64,
        priors: &TrialPriors,
    ) -> Self {
        let after = references.partition_point(|of| of.time_s < time_s);
        let last = after.checked_sub(1).map(|before| references[before]);
        let Some((last, next)) = last.zip(references.get(after)) else {
            return Self {
                mean: Complex64::ZERO,
                damping_by_bend: 0.0,
                reactance_std: priors.plate_reactance_std_n_s_per_m,
                damping_std: None,
                reactance_by_bend: 0.0,
            };
        };
        let change = next.z_p_n_s_per_m - last.z_p_n_s_per_m;
        let error = last.std_n_s_per_m.hypot(next.std_n_s_per_m);
        let share = (time_s - last.time_s) / (next.time_s - last.time_s);
        let bend = 4.0 * share * (1.0 - share);
        let most = change.im.abs().max(REACTANCE_CHANGE_N_S_PER_M);
        Self {
            mean: last.z_p_n_s_per_m - z_p + change * share,
            damping_by_bend: bend * change.re,
            reactance_std: error.hypot(bend * BEND.std * most),
            damping_std: Some(error.max(LEAST_STD_N_S_PER_M)),
            reactance_by_bend: if change.im.abs() < COURSE_N_S_PER_M {
                0.0
            } else {
                bend * change.im
            },
        }
    }

    /// Returns the offset of the damping on its course, N·s/m.
    pub(super) fn damping(&self, bend: f64) -> f64 {
        self.mean.re + bend * self.damping_by_bend
    }
}

/// Returns the bend of the damping that is likely where the reactance has taken the course that it was found to take.
pub(super) fn bend(found: impl Iterator<Item = (OffsetPrior, f64)>) -> Normal {
    let (mut power, mut along) = (0.0, 0.0);
    for (prior, reactance) in found {
        power += prior.reactance_by_bend.powi(2);
        along += prior.reactance_by_bend * (reactance - prior.mean.im);
    }
    let found = along / power;
    if BELIEVED.contains(&found) {
        Normal {
            mean: found,
            std: ASTRAY,
        }
    } else {
        BEND
    }
}
