//! Inverse of the normal matrix of a fit: the covariance of its parameters for unit variance.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector};

/// Squared pivot, of a normal matrix scaled to unit diagonal, below which it is rounding and not information.
const MIN_PIVOT: f64 = 1e-12;

/// Returns the inverse of a normal matrix; `None` if it is singular to rounding. The matrix is scaled to unit diagonal first, so
/// that units do not decide which pivots count as singular.
#[must_use]
pub fn inverse_of_normal<D: Dim>(normal: &OMatrix<f64, D, D>) -> Option<OMatrix<f64, D, D>>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    // N⁻¹ = D (D N D)⁻¹ D with D = diag(1/√N_ii). The squared pivot of a parameter in D N D is the part 1 − R² of its slopes
    // that those of the parameters before it do not explain.
    let (rows, columns) = normal.shape_generic();
    let scale: OVector<f64, D> =
        OVector::from_fn_generic(rows, Const::<1>, |i, _| normal[(i, i)].sqrt().recip());
    if !scale.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let scaled = |matrix: &OMatrix<f64, D, D>| {
        OMatrix::from_fn_generic(rows, columns, |i, j| matrix[(i, j)] * scale[i] * scale[j])
    };
    let factor = scaled(normal).cholesky()?;
    let mut pivots = (0..normal.nrows()).map(|i| factor.l_dirty()[(i, i)]);
    if pivots.any(|pivot| pivot.powi(2) < MIN_PIVOT) {
        return None;
    }
    Some(scaled(&factor.inverse()))
}
