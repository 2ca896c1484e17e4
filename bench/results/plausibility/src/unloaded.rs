//! Normal force in the intervals without a finger: a zero of the sensor, or a finger.

use std::fmt;

use serde::{Deserialize, Serialize};
use statistics::{quantile, significant};

/// Largest zero of a sensor, N, three times that with which a session may begin.
const LARGEST_ZERO_N: f64 = 0.15;
/// Range of the readings, relative to their median, beyond which they are a finger's: a zero is steady.
const UNSTEADY: f64 = 0.15;
/// Shares of the readings that bound their range, and those that stand for the readings without a finger.
const RANGE: [f64; 2] = [0.1, 0.9];
const ENDS: [f64; 2] = [0.01, 0.99];

/// Evidence that a finger was on the plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum UnloadedFinger {
    /// The readings vary as those of a finger, by this range, N.
    Unsteady(f64),
    /// The readings are nearer to zero elsewhere, N.
    FreeElsewhere(f64),
}

impl fmt::Display for UnloadedFinger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unsteady(range_n) => write!(f, "and varies there by {} N", significant(*range_n)),
            Self::FreeElsewhere(free_n) => write!(f, "and {} N elsewhere", significant(*free_n)),
        }
    }
}

/// Returns whether a median without a finger is far from zero, relative to the change of the `touched` readings from it. All readings
/// are sorted.
pub(crate) fn is_far(unloaded_n: f64, touched: &[f64]) -> bool {
    let pressed_n = quantile(touched, 0.5).map_or(0.0, |touched_n| touched_n - unloaded_n);
    // A force in another unit has a zero in it too.
    unloaded_n.abs() > LARGEST_ZERO_N && unloaded_n.abs() > 0.1 * pressed_n.abs()
}

/// Returns the evidence for a finger in the `unloaded` readings, which are far from zero, if there is any. All readings are sorted.
pub(crate) fn finger(unloaded: &[f64], touched: &[f64], all: &[f64]) -> Option<UnloadedFinger> {
    let (unloaded_n, touched_n) = (quantile(unloaded, 0.5)?, quantile(touched, 0.5)?);
    let [low_n, high_n] = RANGE.map(|share| quantile(unloaded, share));
    let range_n = high_n? - low_n?;
    if range_n > UNSTEADY * unloaded_n.abs() {
        return Some(UnloadedFinger::Unsteady(range_n));
    }
    let [first_n, last_n] = ENDS.map(|share| quantile(all, share));
    let (first_n, last_n) = (first_n?, last_n?);
    let free_n = if first_n.abs() < last_n.abs() {
        first_n
    } else {
        last_n
    };
    // Relative to it, both the finger's readings and those in question are loads, in one direction.
    let (unloaded_load_n, touched_load_n) = (unloaded_n - free_n, touched_n - free_n);
    let is_load = unloaded_load_n * touched_load_n > 0.0
        && touched_load_n.abs() > 0.5 * unloaded_load_n.abs()
        && unloaded_load_n.abs() > LARGEST_ZERO_N;
    (free_n.abs() < LARGEST_ZERO_N && is_load).then_some(UnloadedFinger::FreeElsewhere(free_n))
}
