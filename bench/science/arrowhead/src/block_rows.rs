//! Residuals of a block with their slopes.
//!
//! With the parameters θ of a block's model, which depend on the block's own parameters o and on the shared ones s, let G = ∂r/∂θ,
//! A = ∂θ/∂o and B = ∂θ/∂s. The Jacobians of the residuals are J = G A and K = G B. A model has fewer parameters than o and s
//! have together where several of these act on one, so that sums over rows are of G:
//!
//! ```text
//! JᵀJ = Aᵀ(GᵀG)A,   JᵀK = Aᵀ(GᵀG)B,   KᵀK = Bᵀ(GᵀG)B,   Jᵀr = Aᵀ(Gᵀr),   Kᵀr = Bᵀ(Gᵀr)
//! ```

use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix, SVector};

use crate::normal::BlockNormal;

/// Residuals of a block, all in one unit, with their slopes.
#[derive(Debug, Clone)]
pub struct BlockRows<const OWN: usize, const SHARED: usize> {
    /// A residual and its slopes by the parameters of the block's model, (r, G).
    rows: DMatrix<f64>,
    /// A.
    by_own: OMatrix<f64, Dyn, Const<OWN>>,
    /// B.
    by_shared: OMatrix<f64, Dyn, Const<SHARED>>,
}

impl<const OWN: usize, const SHARED: usize> BlockRows<OWN, SHARED> {
    /// Takes rows of a residual and its slopes by the model's parameters, and the derivatives of these parameters by the block's
    /// own and by the shared ones.
    ///
    /// # Panics
    /// If the derivatives are not of as many parameters as the rows have slopes.
    #[must_use]
    pub fn new(
        rows: DMatrix<f64>,
        by_own: OMatrix<f64, Dyn, Const<OWN>>,
        by_shared: OMatrix<f64, Dyn, Const<SHARED>>,
    ) -> Self {
        let parameters = (by_own.nrows(), by_shared.nrows());
        assert_eq!(parameters, (rows.ncols() - 1, rows.ncols() - 1));
        Self {
            rows,
            by_own,
            by_shared,
        }
    }

    /// Returns the number of residuals.
    pub(crate) fn len(&self) -> usize {
        self.rows.nrows()
    }

    /// Returns half the gradient and half the Gauss–Newton Hessian of the sum of squares.
    #[must_use]
    pub fn normal(&self) -> BlockNormal<OWN, SHARED> {
        // (r, G)ᵀ(r, G) has the parts rᵀr, Gᵀr and GᵀG.
        let products = self.rows.transpose() * &self.rows;
        let parameters = self.by_own.nrows();
        let gradient = products.column(0).rows(1, parameters).into_owned();
        let normal = products.view((1, 1), (parameters, parameters));
        let by_own = normal * &self.by_own;
        let by_shared = normal * &self.by_shared;
        BlockNormal {
            squares: products[(0, 0)],
            own_gradient: self.by_own.tr_mul(&gradient),
            shared_gradient: self.by_shared.tr_mul(&gradient),
            own: self.by_own.tr_mul(&by_own),
            coupling: self.by_own.tr_mul(&by_shared),
            shared: self.by_shared.tr_mul(&by_shared),
        }
    }

    /// Returns Jᵀr″ and Kᵀr″ for the second derivative r″ of the residuals along a step, from the residuals at `fraction` of it.
    pub(crate) fn bend_gradient(
        &self,
        (own, shared): (&SVector<f64, OWN>, &SVector<f64, SHARED>),
        fraction: f64,
        residuals: &DVector<f64>,
    ) -> (SVector<f64, OWN>, SVector<f64, SHARED>) {
        // r(θ + h v) = r + h G v + (h²/2) r″ + …, so r″ ≈ (2/h) ((r(θ + h v) − r)/h − G v).
        let step = &self.by_own * own + &self.by_shared * shared;
        let linear = self.slopes() * step;
        let bend = ((residuals - self.rows.column(0)) / fraction - linear) * (2.0 / fraction);
        self.gradient(&bend)
    }

    /// Returns Jᵀu and Kᵀu for the change u = G e of the residuals by an error that changes the model's parameters by e.
    pub(crate) fn error_gradient(
        &self,
        error: &DVector<f64>,
    ) -> (SVector<f64, OWN>, SVector<f64, SHARED>) {
        self.gradient(&(self.slopes() * error))
    }

    fn slopes(&self) -> nalgebra::DMatrixView<'_, f64> {
        self.rows.columns_range(1..)
    }

    fn gradient(&self, residuals: &DVector<f64>) -> (SVector<f64, OWN>, SVector<f64, SHARED>) {
        let gradient = self.slopes().tr_mul(residuals);
        (
            self.by_own.tr_mul(&gradient),
            self.by_shared.tr_mul(&gradient),
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Returns rows whose model's parameters are the block's own, the shared ones and any further ones, in this order.
    pub(crate) fn direct_rows<const OWN: usize, const SHARED: usize>(
        rows: DMatrix<f64>,
    ) -> BlockRows<OWN, SHARED> {
        let parameters = rows.ncols() - 1;
        let mut by_shared =
            OMatrix::<f64, Dyn, Const<SHARED>>::zeros_generic(Dyn(parameters), Const);
        by_shared
            .view_mut((OWN, 0), (SHARED, SHARED))
            .fill_with_identity();
        let by_own = OMatrix::identity_generic(Dyn(parameters), Const);
        BlockRows::new(rows, by_own, by_shared)
    }

    /// Compares with the products of the Jacobians written out, for a parameter that own and shared ones act on together.
    #[test]
    fn sums_are_those_of_the_jacobians() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut number = || -> f64 { StandardNormal.sample(&mut random) };
        let rows = DMatrix::from_fn(11, 5, |_, _| number());
        let by_own = OMatrix::<f64, Dyn, Const<2>>::from_fn(4, |_, _| number());
        let by_shared = OMatrix::<f64, Dyn, Const<3>>::from_fn(4, |_, _| number());
        let (residuals, slopes) = (rows.column(0).into_owned(), rows.columns(1, 4).into_owned());
        let (own_slopes, shared_slopes) = (&slopes * &by_own, &slopes * &by_shared);
        let block = BlockRows::new(rows, by_own, by_shared);
        let normal = block.normal();
        assert!((normal.squares - residuals.norm_squared()).abs() < 1e-13);
        assert!((normal.own_gradient - own_slopes.tr_mul(&residuals)).amax() < 1e-13);
        assert!((normal.shared_gradient - shared_slopes.tr_mul(&residuals)).amax() < 1e-13);
        assert!((normal.own - own_slopes.tr_mul(&own_slopes)).amax() < 1e-13);
        assert!((normal.coupling - own_slopes.tr_mul(&shared_slopes)).amax() < 1e-13);
        assert!((normal.shared - shared_slopes.tr_mul(&shared_slopes)).amax() < 1e-13);
        // Residuals that bend by a known second derivative along a step.
        let step = (SVector::from([0.3, -0.7]), SVector::from([0.2, 0.1, -0.4]));
        let second_derivative = DVector::from_fn(11, |row, _| 1.0 + row as f64);
        let fraction = 0.1;
        let linear = &own_slopes * step.0 + &shared_slopes * step.1;
        let probe =
            residuals + linear * fraction + &second_derivative * (0.5 * fraction * fraction);
        let (own, shared) = block.bend_gradient((&step.0, &step.1), fraction, &probe);
        assert!((own - own_slopes.tr_mul(&second_derivative)).amax() < 1e-9);
        assert!((shared - shared_slopes.tr_mul(&second_derivative)).amax() < 1e-9);
        let error = DVector::from_vec(vec![0.1, 0.2, -0.3, 0.4]);
        let (own, shared) = block.error_gradient(&error);
        assert!((own - own_slopes.tr_mul(&(&slopes * &error))).amax() < 1e-13);
        assert!((shared - shared_slopes.tr_mul(&(&slopes * &error))).amax() < 1e-13);
    }
}
