//! Friction of strokes there and back.

use crate::LARGEST_CROSSTALK;
use crate::implausible::Implausible;

/// Smallest difference of the frictions of both directions, relative to twice their mean: a skin has some percent.
const SMALLEST_DIFFERENCE: f64 = 0.15;

/// Returns the finding of a friction that is larger in each stroke of one direction than in each of the other, by more than the crosstalk of
/// a sensor makes; `strokes` are whether the position grows, and the mean friction.
#[must_use]
pub fn strokes_differ(strokes: &[(bool, f64)]) -> Option<Implausible> {
    let way = |grows: bool| {
        let inside = strokes
            .iter()
            .filter(move |stroke| stroke.0 == grows && stroke.1.is_finite());
        inside.map(|stroke| stroke.1)
    };
    let least = |grows: bool| way(grows).reduce(f64::min);
    let most = |grows: bool| way(grows).reduce(f64::max);
    let mean = |grows: bool| way(grows).sum::<f64>() / way(grows).count() as f64;
    let is_apart = least(true)? > most(false)? || least(false)? > most(true)?;
    let (mu_there, mu_back) = (mean(true), mean(false));
    let half = 0.5 * (mu_there - mu_back).abs();
    let is_large =
        half > LARGEST_CROSSTALK && half > SMALLEST_DIFFERENCE * 0.5 * (mu_there + mu_back);
    (is_apart && is_large).then_some(Implausible::StrokesDiffer { mu_there, mu_back })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_of_unlike_friction_are_named_and_those_that_scatter_not() {
        let found = strokes_differ(&[(true, 0.447), (false, 0.279)]);
        assert!(
            matches!(found, Some(Implausible::StrokesDiffer { .. })),
            "{found:?}"
        );
        for alike in [
            &[(true, 0.40), (false, 0.30)][..],
            &[(true, 1.6), (false, 1.35)],
            &[(true, 0.5), (false, 0.2), (true, 0.19)],
            &[(true, 0.5), (true, 0.1), (true, f64::NAN)],
            &[(true, 0.5), (false, f64::NAN)],
            &[],
        ] {
            assert_eq!(strokes_differ(alike), None, "{alike:?}");
        }
    }
}
