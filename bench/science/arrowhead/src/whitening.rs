//! Whitening of correlated residuals: for a covariance V = L Lᵀ with L lower triangular, W = L⁻¹ has WᵀW = V⁻¹, so
//! |W r|² = rᵀV⁻¹r, and W r has the unit covariance W V Wᵀ.

use nalgebra::DMatrix;

/// Inverse Cholesky factor of a covariance; multiplying residuals by it gives unit covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Whitening(DMatrix<f64>);

/// Largest size that is factored element by element. Larger matrices are split in halves, so that nearly all of the work is in
/// products, which are fast.
const MAX_UNSPLIT_SIZE: usize = 32;
/// Rows multiplied at a time; a band of a lower triangle is zero beyond its last row.
const BAND_ROWS: usize = 64;

impl Whitening {
    /// Returns the whitening of `covariance`, or `None` if it is not positive definite.
    #[must_use]
    pub fn from_covariance(covariance: &DMatrix<f64>) -> Option<Self> {
        inverse_factor(covariance).map(Self)
    }

    /// Multiplies columns that have as many rows as the covariance.
    pub fn apply(&self, columns: &mut DMatrix<f64>) {
        let mut product = DMatrix::zeros(columns.nrows(), columns.ncols());
        for start in (0..self.0.nrows()).step_by(BAND_ROWS) {
            let end = (start + BAND_ROWS).min(self.0.nrows());
            let band = self.0.view((start, 0), (end - start, end));
            product
                .rows_mut(start, end - start)
                .gemm(1.0, &band, &columns.rows(0, end), 0.0);
        }
        *columns = product;
    }
}

/// Returns the inverse Cholesky factor of a covariance, or `None` if it is not positive definite.
fn inverse_factor(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = covariance.nrows();
    let mut inverse = DMatrix::identity(n, n);
    if n <= MAX_UNSPLIT_SIZE {
        let factor = covariance.clone().cholesky()?.unpack();
        return factor
            .solve_lower_triangular_mut(&mut inverse)
            .then_some(inverse);
    }
    let half = n / 2;
    let block =
        |start: (usize, usize), size: (usize, usize)| covariance.view(start, size).into_owned();
    let first = inverse_factor(&block((0, 0), (half, half)))?;
    // For V with the blocks A, Bᵀ; B, D: W_A A W_Aᵀ = 1 and K = B W_Aᵀ couples the second half to the whitened first. The
    // second half given the first has the covariance D − B A⁻¹Bᵀ = D − K Kᵀ, with the whitening W_S. The inverse factor is
    // W_A, 0; −W_S K W_A, W_S.
    let coupling = block((half, 0), (n - half, half)) * first.transpose();
    let complement = block((half, half), (n - half, n - half)) - &coupling * coupling.transpose();
    let second = inverse_factor(&complement)?;
    let coupling = &second * coupling * &first;
    inverse.view_mut((0, 0), first.shape()).copy_from(&first);
    inverse
        .view_mut((half, half), second.shape())
        .copy_from(&second);
    inverse
        .view_mut((half, 0), coupling.shape())
        .copy_from(&-coupling);
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
    fn whitened_residuals_have_unit_covariance() {
        for n in [
            1,
            MAX_UNSPLIT_SIZE,
            MAX_UNSPLIT_SIZE + 1,
            BAND_ROWS + 1,
            5 * MAX_UNSPLIT_SIZE,
        ] {
            let mut columns = covariance(n).cholesky().unwrap().unpack();
            Whitening::from_covariance(&covariance(n))
                .unwrap()
                .apply(&mut columns);
            let deviation = columns - DMatrix::identity(n, n);
            assert!(deviation.amax() < 1e-10, "{n}: {}", deviation.amax());
        }
        assert_eq!(
            Whitening::from_covariance(&-covariance(3 * MAX_UNSPLIT_SIZE)),
            None
        );
    }
}
