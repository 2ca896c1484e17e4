//! Variances and correlation of residuals.

use nalgebra::DMatrix;

const ITERATIONS: usize = 50;

/// Returns the non-negative variances of the kinds that best explain the squares. For each square, `kinds` gives the
/// contribution of a unit variance of each kind; their sum is at least `least`. Maximum likelihood of normal residuals by
/// Fisher scoring, as weighted least squares of the squares on the kinds, one kind after the other.
#[must_use]
pub fn variance_components<const N: usize>(
    squares: &[f64],
    kinds: &[[f64; N]],
    least: f64,
) -> [f64; N] {
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let mut variances: [f64; N] = std::array::from_fn(|k| {
        let of_kind = kinds.iter().map(|kind| kind[k]).sum::<f64>() / kinds.len() as f64;
        if of_kind > 0.0 {
            mean / of_kind / N as f64
        } else {
            0.0
        }
    });
    for _ in 0..ITERATIONS {
        let sum = |variances: &[f64; N], kind: &[f64; N]| -> f64 {
            variances.iter().zip(kind).map(|(v, k)| v * k).sum()
        };
        let weights: Vec<f64> = kinds
            .iter()
            .map(|kind| sum(&variances, kind).max(least).powi(-2))
            .collect();
        for k in 0..N {
            let (mut power, mut along) = (0.0, 0.0);
            for ((kind, &square), &weight) in kinds.iter().zip(squares).zip(&weights) {
                let rest = square - sum(&variances, kind) + variances[k] * kind[k];
                power += weight * kind[k] * kind[k];
                along += weight * kind[k] * rest;
            }
            if power > 0.0 {
                variances[k] = (along / power).max(0.0);
            }
        }
    }
    variances
}

/// Returns the correlation of samples with errors that decay over `intervals` sampling intervals.
#[must_use]
pub fn lasting(samples: usize, intervals: f64) -> DMatrix<f64> {
    let by_distance: Vec<f64> = (0..samples)
        .map(|of| (-(of as f64) / intervals).exp())
        .collect();
    DMatrix::from_fn(samples, samples, |row, column| {
        by_distance[row.abs_diff(column)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_found_and_none_is_negative() {
        let kinds: Vec<[f64; 3]> = (0..200)
            .map(|n| match n % 3 {
                0 => [1.0, 0.0, 0.0],
                1 => [1.0, 8.0, 0.0],
                _ => [1.0, 0.5, 5.0],
            })
            .collect();
        for truth in [[0.5, 0.02, 0.3], [0.4, 0.0, 0.0]] {
            let square = |kind: &[f64; 3]| truth.iter().zip(kind).map(|(v, k)| v * k).sum();
            let squares: Vec<f64> = kinds.iter().map(square).collect();
            let found = variance_components(&squares, &kinds, 1e-9);
            for (found, truth) in found.iter().zip(truth) {
                assert!(
                    *found >= 0.0 && (found - truth).abs() < 1e-3,
                    "{found} {truth}"
                );
            }
        }
    }

    #[test]
    fn errors_that_last_correlate_by_their_distance() {
        let found = lasting(4, 2.0);
        assert_eq!(found[(1, 1)], 1.0);
        assert!((found[(0, 3)] - (-1.5f64).exp()).abs() < 1e-15);
        assert_eq!(found, found.transpose());
    }
}
