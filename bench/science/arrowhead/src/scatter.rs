//! Variances and correlation of residuals.

use nalgebra::DMatrix;

const ITERATIONS: usize = 50;

/// Returns the non-negative variances of the kinds that best explain the squares. For each square, `kinds` gives the
/// contribution of a unit variance of each kind; their sum is at least `floor`. Maximum likelihood of normal residuals by
/// Fisher scoring, as weighted least squares of the squares on the kinds, one kind after the other.
#[must_use]
pub fn variance_components<const N: usize>(
    squares: &[f64],
    kinds: &[[f64; N]],
    floor: f64,
) -> [f64; N] {
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let mut variances: [f64; N] = std::array::from_fn(|k| {
        let contribution = kinds.iter().map(|kind| kind[k]).sum::<f64>() / kinds.len() as f64;
        if contribution > 0.0 {
            mean / contribution / N as f64
        } else {
            0.0
        }
    });
    // A normal residual with the variance V = Σ v_k q_k has E r² = V and Var r² = 2 V². Weighted least squares of r² on the q_k
    // with the weights 1/V² of the last variances solves the likelihood equations Σ (r² − V) q_k/V² = 0. Each v_k in turn:
    // v_k = Σ q_k (r² − Σ_(l≠k) v_l q_l)/V² / Σ q_k²/V², not below 0.
    for _ in 0..ITERATIONS {
        let sum = |variances: &[f64; N], kind: &[f64; N]| -> f64 {
            variances.iter().zip(kind).map(|(v, k)| v * k).sum()
        };
        let weights: Vec<f64> = kinds
            .iter()
            .map(|kind| sum(&variances, kind).max(floor).powi(-2))
            .collect();
        for k in 0..N {
            let (mut power, mut projection) = (0.0, 0.0);
            for ((kind, &square), &weight) in kinds.iter().zip(squares).zip(&weights) {
                let remainder = square - sum(&variances, kind) + variances[k] * kind[k];
                power += weight * kind[k] * kind[k];
                projection += weight * kind[k] * remainder;
            }
            if power > 0.0 {
                variances[k] = (projection / power).max(0.0);
            }
        }
    }
    variances
}

/// Returns the correlation of samples with errors that decay over `intervals` sampling intervals c: exp(−|j − k|/c), that of an
/// Ornstein–Uhlenbeck process.
#[must_use]
pub fn exponential_correlation(samples: usize, intervals: f64) -> DMatrix<f64> {
    let correlations: Vec<f64> = (0..samples)
        .map(|lag| (-(lag as f64) / intervals).exp())
        .collect();
    DMatrix::from_fn(samples, samples, |row, column| {
        correlations[row.abs_diff(column)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_estimated_and_not_negative() {
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
            let variances = variance_components(&squares, &kinds, 1e-9);
            for (variance, truth) in variances.iter().zip(truth) {
                assert!(
                    *variance >= 0.0 && (variance - truth).abs() < 1e-3,
                    "{variance} {truth}"
                );
            }
        }
    }

    #[test]
    fn the_correlation_decays_with_the_distance() {
        let correlation = exponential_correlation(4, 2.0);
        assert_eq!(correlation[(1, 1)], 1.0);
        assert!((correlation[(0, 3)] - (-1.5f64).exp()).abs() < 1e-15);
        assert_eq!(correlation, correlation.transpose());
    }
}
