//! Quantiles, straight lines, angles, linear interpolation, printed numbers and constants that several packages use.

pub mod interpolation;
mod printed;
mod straight_line;

pub use printed::{error_decimals, significant, with_error};
pub use straight_line::StraightLine;

use std::f64::consts::{PI, TAU};

/// Quantile of the normal distribution at 97.5 %: 95 % lie within this many standard deviations.
pub const NORMAL_95: f64 = 1.959_964;

/// Returns the quantile of sorted values at `share`, 0 to 1: linear between order statistics (Hyndman and Fan 1996, definition 7,
/// the default of numpy). `None` without values.
///
/// ```
/// assert_eq!(statistics::quantile(&[1.0, 2.0, 4.0], 0.75), Some(3.0));
/// assert_eq!(statistics::quantile(&[], 0.5), None);
/// ```
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = share * sorted.len().checked_sub(1)? as f64;
    let (lower, upper) = (rank.floor() as usize, rank.ceil() as usize);
    Some(sorted[lower] + (sorted[upper] - sorted[lower]) * rank.fract())
}

/// Returns the median; the mean of the middle two of an even number of values. `None` without values.
///
/// ```
/// assert_eq!(statistics::median([3.0, 1.0, 2.0]), Some(2.0));
/// assert_eq!(statistics::median([4.0, 1.0]), Some(2.5));
/// ```
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(0.5 * (values[last / 2] + values[last.div_ceil(2)]))
}

/// Returns the angle between −π and π, rad.
///
/// ```
/// assert!((statistics::wrap_rad(7.0) - (7.0 - std::f64::consts::TAU)).abs() < 1e-12);
/// ```
#[must_use]
pub fn wrap_rad(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_linearly_between_order_statistics() {
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[3.0], 0.9), Some(3.0));
        assert_eq!(quantile(&[1.0, 2.0, 4.0, 8.0], 0.5), Some(3.0));
        assert_eq!(quantile(&[0.0, 10.0], 0.9), Some(9.0));
    }

    #[test]
    fn quantiles_reach_both_ends() {
        let values = [1.0, 3.0, 9.0];
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 1.0), Some(9.0));
        assert_eq!(quantile(&[2.0], 0.3), Some(2.0));
    }

    #[test]
    fn angles_of_any_turn_lie_within_half_a_turn() {
        for turns in -3..=3 {
            for angle_rad in [-3.1, -1.0, 0.0, 0.5, 3.1] {
                let wrapped = wrap_rad(angle_rad + f64::from(turns) * TAU);
                assert!((wrapped - angle_rad).abs() < 1e-12, "{wrapped}");
            }
        }
        assert!(wrap_rad(PI).abs() <= PI && wrap_rad(-PI).abs() <= PI);
    }
}
