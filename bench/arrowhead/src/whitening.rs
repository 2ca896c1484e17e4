//! Residuals that scatter together, made independent.

use nalgebra::DMatrix;

/// The inverse of a covariance's lower factor: what had that covariance has, multiplied by it, one of 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Whitening(DMatrix<f64>);

/// Size up to which a matrix is factored element by element; beyond, by halves: nearly all of the work is then in products, which
/// are fast.
const SMALL: usize = 32;
/// Rows that are multiplied at a time: a band of a lower triangle is empty beyond its last row.
const BAND: usize = 64;

impl Whitening {
    /// Returns that of a covariance; `None` of a matrix that is none.
    #[must_use]
    pub fn of(covariance: &DMatrix<f64>) -> Option<Self> {
        inverse_factor(covariance).map(Self)
    }

    /// Multiplies columns, of as many rows as the covariance has.
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

/// Returns the inverse of the lower factor of a covariance; `None` of a matrix that is none.
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
    // What the second half shares with the first, in units of what is the first's alone.
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
