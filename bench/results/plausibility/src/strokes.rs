//! Friction that differs within a recording: of strokes there and back, and before and after a time.

use statistics::median;

use crate::LARGEST_CROSSTALK;
use crate::friction_split::FrictionSplit;
use crate::implausible::Implausible;

/// Smallest difference of the frictions of both directions, relative to twice their mean: a skin has some percent.
const SMALLEST_DIFFERENCE: f64 = 0.15;
/// Ratios of the amplitudes and of the mean speeds of two strokes up to which they are alike: a finger that rests for a part of a stroke has
/// a lower mean of both friction and speed.
const LIKE_AMPLITUDES: f64 = 1.2;
const LIKE_SPEEDS: f64 = 1.3;
/// Smallest ratio of a friction at rest after a time to that before it, greatest relative deviation from either, and fewest instances.
const SMALLEST_JUMP: f64 = 1.3;
const STEADY: f64 = 0.12;
const FEWEST: usize = 2;

/// Mean friction of a stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrokeFriction {
    /// Whether the position grows.
    pub grows: bool,
    /// Friction; NaN where it is unknown.
    pub mu: f64,
    /// Amplitude of the plate, m; NaN where it is unknown.
    pub amplitude_m: f64,
    /// Mean speed, m/s; NaN where it is unknown.
    pub speed_m_per_s: f64,
}

/// Returns the finding of a friction that is larger in each stroke of one direction than in each of the other, by more than a sensor's
/// crosstalk makes, under one amplitude and at one speed.
#[must_use]
pub fn strokes_differ(strokes: &[StrokeFriction]) -> Option<Implausible> {
    let are_alike = |value: fn(&StrokeFriction) -> f64, ratio: f64| {
        let values = || strokes.iter().map(value);
        let least = values().fold(f64::INFINITY, f64::min);
        values().fold(0.0, f64::max) < ratio * least
    };
    if !are_alike(|stroke| stroke.amplitude_m, LIKE_AMPLITUDES)
        || !are_alike(|stroke| stroke.speed_m_per_s.abs(), LIKE_SPEEDS)
    {
        return None;
    }
    let way = |grows: bool| {
        let inside = strokes
            .iter()
            .filter(move |stroke| stroke.grows == grows && stroke.mu.is_finite());
        inside.map(|stroke| stroke.mu)
    };
    let least = |grows: bool| way(grows).reduce(f64::min);
    let most = |grows: bool| way(grows).reduce(f64::max);
    let mean = |grows: bool| way(grows).sum::<f64>() / way(grows).count() as f64;
    let is_apart = least(true)? > most(false)? || least(false)? > most(true)?;
    let (mu_there, mu_back) = (mean(true), mean(false));
    let half = 0.5 * (mu_there - mu_back).abs();
    let is_large =
        half > LARGEST_CROSSTALK && half > SMALLEST_DIFFERENCE * 0.5 * (mu_there + mu_back);
    (is_apart && is_large).then_some(Implausible::FrictionDiffers {
        mu: [mu_there, mu_back],
        split: FrictionSplit::Direction,
    })
}

/// Returns the finding of a friction at rest that jumps once and is steady before and after; `instances` are the times, s, in order, and
/// the friction at rest of each.
#[must_use]
pub fn friction_jumps(instances: &[(f64, f64)]) -> Option<Implausible> {
    let steady = |part: &[(f64, f64)]| -> Option<f64> {
        let middle = median(part.iter().map(|instance| instance.1))?;
        let is_near = |instance: &(f64, f64)| (instance.1 / middle - 1.0).abs() < STEADY;
        (part.len() >= FEWEST && middle > 0.0 && part.iter().all(is_near)).then_some(middle)
    };
    (1..instances.len()).find_map(|index| {
        let (earlier, later) = instances.split_at(index);
        let mu = [steady(earlier)?, steady(later)?];
        let ratio = mu[1] / mu[0];
        (ratio.max(ratio.recip()) > SMALLEST_JUMP).then(|| Implausible::FrictionDiffers {
            mu,
            split: FrictionSplit::Time {
                at_s: 0.5 * (earlier[index - 1].0 + later[0].0),
            },
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_of_unlike_friction_are_named_and_those_that_scatter_not() {
        let moved = |mu: &[(bool, f64)], amplitudes_m: [f64; 2], speeds_m_per_s: [f64; 2]| {
            let strokes = mu.iter().map(|(grows, mu)| StrokeFriction {
                grows: *grows,
                mu: *mu,
                amplitude_m: amplitudes_m[usize::from(*grows)],
                speed_m_per_s: speeds_m_per_s[usize::from(*grows)],
            });
            strokes_differ(&strokes.collect::<Vec<_>>())
        };
        let strokes = |mu: &[(bool, f64)], amplitudes_m| moved(mu, amplitudes_m, [0.05; 2]);
        let apart = [(true, 0.447), (false, 0.279)];
        for amplitudes_m in [[2e-6, 2.1e-6], [f64::NAN; 2]] {
            let found = strokes(&apart, amplitudes_m);
            assert!(
                matches!(found, Some(Implausible::FrictionDiffers { .. })),
                "{found:?}"
            );
        }
        assert_eq!(strokes(&apart, [2e-6, 1e-6]), None);
        assert_eq!(moved(&apart, [2e-6; 2], [0.024, 0.044]), None);
        assert!(moved(&apart, [f64::NAN; 2], [f64::NAN; 2]).is_some());
        for alike in [
            &[(true, 0.40), (false, 0.30)][..],
            &[(true, 1.6), (false, 1.35)],
            &[(true, 0.5), (false, 0.2), (true, 0.19)],
            &[(true, 0.5), (true, 0.1), (true, f64::NAN)],
            &[(true, 0.5), (false, f64::NAN)],
            &[],
        ] {
            assert_eq!(strokes(alike, [2e-6; 2]), None, "{alike:?}");
        }
    }

    #[test]
    fn a_friction_that_jumps_once_is_named_and_one_that_drifts_or_scatters_not() {
        let instances = |mu: &[f64]| -> Vec<(f64, f64)> {
            mu.iter()
                .enumerate()
                .map(|(index, mu)| (index as f64, *mu))
                .collect()
        };
        let found = friction_jumps(&instances(&[0.82, 0.80, 0.82, 0.84, 1.62, 1.62, 1.62]));
        let Some(Implausible::FrictionDiffers {
            mu,
            split: FrictionSplit::Time { at_s },
        }) = found
        else {
            panic!("{found:?}");
        };
        assert_eq!((mu, at_s), ([0.82, 1.62], 3.5));
        for steady in [
            &[0.80, 0.82, 0.79, 0.90, 0.92, 0.95][..],
            &[0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1],
            &[0.8, 0.8, 0.8, 1.6],
            &[0.8, 1.6, 0.8, 1.6],
            &[0.8, f64::NAN, 1.6, 1.6],
            &[],
        ] {
            assert_eq!(friction_jumps(&instances(steady)), None, "{steady:?}");
        }
    }
}
