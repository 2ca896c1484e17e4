//! Whitening of correlated residuals.

use nalgebra::DMatrix;

/// Inverse Cholesky factor of a covariance; multiplying residuals by it gives unit covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Whitening(DMatrix<f64>);

/// Largest size that is factored element by element. Larger matrices are split in halves, so that nearly all of the work is in
/// products, which are fast.
const SMALL: usize = 32;
/// Rows multiplied at a time; a band of a lower triangle is zero beyond its last row.
const BAND: usize = 64;

impl Whitening {
    /// Returns the whitening of `covariance`, or `None` if it is not positive definite.
    #[must_use]
    pub fn of(covariance: &DMatrix<f64>) -> Option<Self> {
        inverse_factor(covariance).map(Self)
    }

    /// Multiplies columns that have as many rows as the covariance.
    pub fn apply(&self, columns: &mut DMatrix<f64>) {
        let mut whitened = DMatrix::zeros(columns.nrows(), columns.ncols());
        for from in (0..self.0.nrows()).step_by(BAND) {
            let to = (from + BAND).min(self.0.nrows());
            let band = self.0.view((from, 0), (to - from, to));
            whitened
                .rows_mut(from, to - from)
                .gemm(1.0, &band, &columns.rows(0, to), 0.0);
        }
        *columns = whitened;
    }
}

/// Returns the inverse Cholesky factor of a covariance, or `None` if it is not positive definite.
fn inverse_factor(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = covariance.nrows();
    let mut inverse = DMatrix::identity(n, n);
    if n <= SMALL {
        let factor = covariance.clone().cholesky()?.unpack();
        return factor
            .solve_lower_triangular_mut(&mut inverse)
            .then_some(inverse);
    }
    let half = n / 2;
    let part = |at: (usize, usize), size: (usize, usize)| covariance.view(at, size).into_owned();
    let first = inverse_factor(&part((0, 0), (half, half)))?;
    // Coupling of the second half to the whitened first half.
    let across = part((half, 0), (n - half, half)) * first.transpose();
    let alone = part((half, half), (n - half, n - half)) - &across * across.transpose();
    let second = inverse_factor(&alone)?;
    let across = &second * across * &first;
    inverse.view_mut((0, 0), first.shape()).copy_from(&first);
    inverse
        .view_mut((half, half), second.shape())
        .copy_from(&second);
    inverse
        .view_mut((half, 0), across.shape())
        .copy_from(&-across);
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covariance(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |row, column| {
            (-(row.abs_diff(column) as f64) / 3.0).exp()
        })
    }

    #[test]
    fn what_is_whitened_has_a_covariance_of_1() {
        for n in [1, SMALL, SMALL + 1, BAND + 1, 5 * SMALL] {
            let mut whitened = covariance(n).cholesky().unwrap().unpack();
            Whitening::of(&covariance(n)).unwrap().apply(&mut whitened);
            let apart = whitened - DMatrix::identity(n, n);
            assert!(apart.amax() < 1e-10, "{n}: {}", apart.amax());
        }
        assert_eq!(Whitening::of(&-covariance(3 * SMALL)), None);
    }
}
