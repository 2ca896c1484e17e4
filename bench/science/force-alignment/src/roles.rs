//! Exchange of the normal and the lateral force.
//!
//! Friction follows the modulation: the film lifts the finger once in each period. The normal force is the participant's, and
//! changes slowly. So the column whose values at the modulation's frequency are large relative to its mean is the lateral force,
//! at any delay, scale and sign.

use num_complex::Complex64;
use std::f64::consts::TAU;

use crate::film::ForceSample;

/// Smallest modulated share of a lateral force, and its smallest ratio to that of the normal force, for an exchange.
const SMALLEST_SHARE: f64 = 0.15;
const SMALLEST_RATIO: f64 = 3.0;
/// Fewest periods of the modulation in a slide.
const FEWEST_PERIODS: f64 = 2.0;
/// Fewest readings in a period.
const FEWEST_PER_PERIOD: f64 = 8.0;

/// Modulated share of both columns in a slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulatedShares {
    /// Share of the column stated as the normal force.
    pub normal: f64,
    /// Share of the column stated as the lateral force.
    pub lateral: f64,
}

/// Returns the median modulated shares if the columns are exchanged in most of the slides and confirmed in none.
#[must_use]
pub fn exchanged(
    forces: &[ForceSample],
    slides_s: &[(f64, f64)],
    modulation_hz: f64,
) -> Option<ModulatedShares> {
    let shares = slides_s
        .iter()
        .filter_map(|slide| shares(forces, *slide, modulation_hz));
    let shares: Vec<ModulatedShares> = shares.collect();
    let is_exchanged = |share: &&ModulatedShares| {
        share.normal > SMALLEST_SHARE && share.normal > SMALLEST_RATIO * share.lateral
    };
    let is_confirmed = |share: &ModulatedShares| share.lateral > share.normal;
    let exchanged = shares.iter().filter(is_exchanged).count();
    if 2 * exchanged <= shares.len() || shares.iter().any(is_confirmed) {
        return None;
    }
    Some(ModulatedShares {
        normal: statistics::median(shares.iter().map(|share| share.normal))?,
        lateral: statistics::median(shares.iter().map(|share| share.lateral))?,
    })
}

/// Returns the modulated shares of both columns over whole periods of the modulation in a slide.
fn shares(
    forces: &[ForceSample],
    (start_s, end_s): (f64, f64),
    modulation_hz: f64,
) -> Option<ModulatedShares> {
    let periods = ((end_s - start_s) * modulation_hz).floor();
    if periods.is_nan() || periods < FEWEST_PERIODS {
        return None;
    }
    let middle_s = 0.5 * (start_s + end_s);
    let half_s = 0.5 * periods / modulation_hz;
    let start = forces.partition_point(|force| force.time_s < middle_s - half_s);
    let end = forces.partition_point(|force| force.time_s < middle_s + half_s);
    let is_finite = |force: &&ForceSample| force.normal.is_finite() && force.lateral.is_finite();
    let inside: Vec<&ForceSample> = forces.get(start..end)?.iter().filter(is_finite).collect();
    let n = inside.len() as f64;
    if n < FEWEST_PER_PERIOD * periods {
        return None;
    }
    let share = |value: fn(&ForceSample) -> f64| {
        let mean = inside.iter().map(|force| value(force)).sum::<f64>() / n;
        let tone = |force: &&ForceSample| {
            (value(force) - mean) * Complex64::cis(-TAU * modulation_hz * force.time_s)
        };
        2.0 * inside.iter().map(tone).sum::<Complex64>().norm() / n / mean.abs()
    };
    let shares = ModulatedShares {
        normal: share(|force| force.normal),
        lateral: share(|force| force.lateral),
    };
    (shares.normal.is_finite() && shares.lateral.is_finite()).then_some(shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forces(depth: f64) -> Vec<ForceSample> {
        let force = |step: i32| {
            let time_s = f64::from(step) * 1e-3;
            let normal = 0.6 + 0.05 * (TAU * 1.1 * time_s).sin();
            let friction = 0.4 * (1.0 + depth * (TAU * 6.0 * time_s).sin());
            ForceSample {
                time_s,
                normal,
                lateral: -normal * friction,
            }
        };
        (0..3000).map(force).collect()
    }

    #[test]
    fn columns_are_exchanged_only_if_the_normal_force_follows_the_modulation() {
        let slides = [(0.1, 1.6), (1.7, 2.9)];
        let stated = forces(0.8);
        assert_eq!(exchanged(&stated, &slides, 6.0), None);
        let swap = |force: &ForceSample| ForceSample {
            normal: force.lateral,
            lateral: force.normal,
            ..*force
        };
        let swapped: Vec<ForceSample> = stated.iter().map(swap).collect();
        let found = exchanged(&swapped, &slides, 6.0).unwrap();
        assert!(
            (found.normal - 0.8).abs() < 0.05 && found.lateral < 0.1,
            "{found:?}"
        );
        // Without a modulation of friction, nothing is known.
        let flat: Vec<ForceSample> = forces(0.0).iter().map(swap).collect();
        assert_eq!(exchanged(&flat, &slides, 6.0), None);
        assert_eq!(exchanged(&swapped, &[], 6.0), None);
    }
}
