//! Covariance of a minimum, from the scatter of its residuals and from errors that no residual shows.
//!
//! In the notation of `normal.rs`, to first order an error of the gradient g moves the minimum by −N⁻¹g, so gradients with the
//! covariance M give Cov θ = N⁻¹M N⁻¹. With R_b = o_b⁻¹c_b and the Schur complement Q = s − Σ c_bᵀR_b, the errors of the
//! shared and of a block's parameters, and their covariances, are
//!
//! ```text
//! e_s = −Q⁻¹ Σ (g_s,b − R_bᵀg_b),   e_b = −o_b⁻¹g_b − R_b e_s
//! Cov e_s       = Q⁻¹ [Σ (M_ss − M_osᵀR_b − R_bᵀ(M_os − M_oo R_b)) + prior] Q⁻¹
//! Cov(e_b, e_s) = D_b − R_b Cov e_s,   D_b = o_b⁻¹ (M_os − M_oo R_b) Q⁻¹
//! Cov e_b       = o_b⁻¹M_oo o_b⁻¹ + R_b Cov e_s R_bᵀ − D_b R_bᵀ − R_b D_bᵀ
//! ```
//!
//! where M_oo, M_os and M_ss are the blocks of M of one block's gradient; gradients of different blocks are independent.
//! `prior` is diagonal, with `prior_scatter` on it: a prior of precision p adds p to M as it does to N. In the code
//! `shared_response` is R_b, `coupling_scatter` M_os − M_oo R_b and `direct_term` D_b.

use nalgebra::{Const, Dyn, OMatrix, SMatrix, SVector};

use crate::normal_matrix::inverse_of_normal;

use crate::block_rows::BlockRows;
use crate::minimise::ArrowMinimum;
use crate::normal::{BlockNormal, ParameterPoint};

/// Covariance of the shared parameters, and of each block's own parameters with the shared ones.
pub struct ArrowCovariance<const OWN: usize, const SHARED: usize, const ERRORS: usize> {
    /// Covariance of the shared parameters.
    pub shared: SMatrix<f64, SHARED, SHARED>,
    /// Covariance of each block's own parameters.
    pub blocks: Vec<BlockCovariance<OWN, SHARED>>,
    /// Response of the minimum to errors that are not fitted; the covariances include it.
    pub response: ArrowResponse<OWN, SHARED, ERRORS>,
    /// Scatter of each block's gradient, and of the shared parameters' priors.
    scatter: (Vec<BlockNormal<OWN, SHARED>>, SVector<f64, SHARED>),
}

impl<const OWN: usize, const SHARED: usize, const ERRORS: usize>
    ArrowCovariance<OWN, SHARED, ERRORS>
{
    /// Returns the covariance with a response to unfitted errors added.
    #[must_use]
    pub fn with_response(mut self, response: ArrowResponse<OWN, SHARED, ERRORS>) -> Self {
        // Independent errors of unit variance with the responses ρ add ρρᵀ.
        self.shared += response.shared * response.shared.transpose();
        for (block, own_response) in self.blocks.iter_mut().zip(&response.own) {
            block.own += own_response * own_response.transpose();
            block.cross += own_response * response.shared.transpose();
        }
        self.response = response;
        self
    }
}

impl<const OWN: usize, const SHARED: usize, const ERRORS: usize>
    ArrowCovariance<OWN, SHARED, ERRORS>
{
    /// Returns the covariance with an unfitted error added that moves the minimum by `response`.
    #[must_use]
    pub fn with_error(mut self, error: usize, response: &ParameterPoint<OWN, SHARED>) -> Self {
        self.shared += response.shared * response.shared.transpose();
        self.response.shared.set_column(error, &response.shared);
        let blocks = self.blocks.iter_mut().zip(&mut self.response.own);
        for ((block, block_response), own) in blocks.zip(&response.own) {
            block.own += own * own.transpose();
            block.cross += own * response.shared.transpose();
            block_response.set_column(error, own);
        }
        self
    }
}

/// Covariance of a block's own parameters, and of these with the shared ones.
pub struct BlockCovariance<const OWN: usize, const SHARED: usize> {
    /// Covariance of the own parameters.
    pub own: SMatrix<f64, OWN, OWN>,
    /// Covariance between own and shared parameters.
    pub cross: SMatrix<f64, OWN, SHARED>,
}

/// Response of a minimum to errors that are not fitted, with one column for each error.
pub struct ArrowResponse<const OWN: usize, const SHARED: usize, const ERRORS: usize> {
    /// Response of the shared parameters.
    pub shared: SMatrix<f64, SHARED, ERRORS>,
    /// Response of each block's own parameters.
    pub own: Vec<SMatrix<f64, OWN, ERRORS>>,
}

impl<const OWN: usize, const SHARED: usize, const ERRORS: usize>
    ArrowResponse<OWN, SHARED, ERRORS>
{
    fn zeros(blocks: usize) -> Self {
        Self {
            shared: SMatrix::zeros(),
            own: vec![SMatrix::zeros(); blocks],
        }
    }
}

impl<const OWN: usize, const SHARED: usize> ArrowMinimum<OWN, SHARED> {
    /// Returns these parameters with the gradient and normal matrix of another minimum.
    #[must_use]
    pub fn with_normal_of(self, other: Self) -> Self {
        Self {
            arrow: other.arrow,
            ..self
        }
    }

    /// Returns the covariance of the parameters for gradients with the given `scatter` and `prior_scatter`: the scatter between
    /// two inverse normal matrices (Huber 1967), block by block. `None` if the data do not determine a combination of
    /// parameters.
    #[must_use]
    pub fn covariance<const ERRORS: usize>(
        &self,
        scatter: Vec<BlockNormal<OWN, SHARED>>,
        prior_scatter: SVector<f64, SHARED>,
    ) -> Option<ArrowCovariance<OWN, SHARED, ERRORS>> {
        let mut schur = self.arrow.shared;
        let mut shared_scatter = SMatrix::from_diagonal(&prior_scatter);
        let mut terms = Vec::with_capacity(scatter.len());
        for (block, scatter) in self.arrow.blocks.iter().zip(&scatter) {
            let inverse = inverse_of_normal(&block.own)?;
            let shared_response = inverse * block.coupling;
            schur -= block.coupling.transpose() * shared_response;
            // Contribution of a block's gradient to the shared one, after its own parameters are eliminated.
            let coupling_scatter = scatter.coupling - scatter.own * shared_response;
            shared_scatter += scatter.shared
                - scatter.coupling.transpose() * shared_response
                - shared_response.transpose() * coupling_scatter;
            terms.push((inverse, shared_response, coupling_scatter));
        }
        let schur_inverse = inverse_of_normal(&schur)?;
        let shared = schur_inverse * shared_scatter * schur_inverse;
        let blocks = terms
            .into_iter()
            .zip(&scatter)
            .map(|((inverse, shared_response, coupling_scatter), scatter)| {
                let direct_term = inverse * coupling_scatter * schur_inverse;
                let cross_term = direct_term * shared_response.transpose();
                BlockCovariance {
                    own: inverse * scatter.own * inverse
                        + shared_response * shared * shared_response.transpose()
                        - cross_term
                        - cross_term.transpose(),
                    cross: direct_term - shared_response * shared,
                }
            })
            .collect();
        Some(ArrowCovariance {
            shared,
            blocks,
            response: ArrowResponse::zeros(scatter.len()),
            scatter: (scatter, prior_scatter),
        })
    }

    /// Returns the covariance of a linear combination of all parameters with each of them, from the scatter behind
    /// `covariance`, without its response to errors.
    #[must_use]
    pub fn combination_covariance<const ERRORS: usize>(
        &self,
        covariance: &ArrowCovariance<OWN, SHARED, ERRORS>,
        combination: &ParameterPoint<OWN, SHARED>,
    ) -> Option<ParameterPoint<OWN, SHARED>> {
        let (blocks, prior) = &covariance.scatter;
        // For a combination k, Cov(θ, kᵀθ) = N⁻¹M N⁻¹k. A step is −N⁻¹ times its argument: two of them leave the sign.
        let step = self.arrow.step(0.0, combination)?;
        let mut gradient = ParameterPoint {
            shared: step.shared.component_mul(prior),
            own: Vec::with_capacity(blocks.len()),
        };
        for (block, own_step) in blocks.iter().zip(&step.own) {
            let own_gradient = block.own * own_step + block.coupling * step.shared;
            gradient.own.push(own_gradient);
            gradient.shared += block.coupling.tr_mul(own_step) + block.shared * step.shared;
        }
        self.arrow.step(0.0, &gradient)
    }

    /// Returns the response of the minimum to errors that act on the parameters of each block's model by `by_error`.
    #[must_use]
    pub fn response<const ERRORS: usize>(
        &self,
        rows: &[BlockRows<OWN, SHARED>],
        by_error: &OMatrix<f64, Dyn, Const<ERRORS>>,
    ) -> Option<ArrowResponse<OWN, SHARED, ERRORS>> {
        let mut response = ArrowResponse::<OWN, SHARED, ERRORS>::zeros(rows.len());
        for error in 0..ERRORS {
            let mut gradient = ParameterPoint {
                shared: SVector::zeros(),
                own: Vec::with_capacity(rows.len()),
            };
            // An error that moves the residuals by u moves the minimum by −N⁻¹Jᵀu.
            for rows in rows {
                let (own, shared) = rows.error_gradient(&by_error.column(error).into_owned());
                gradient.own.push(own);
                gradient.shared += shared;
            }
            let step = self.arrow.step(0.0, &gradient)?;
            response.shared.set_column(error, &step.shared);
            for (block, own_step) in response.own.iter_mut().zip(step.own) {
                block.set_column(error, &own_step);
            }
        }
        Some(response)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::block_rows::tests::direct_rows;
    use crate::normal::Arrow;

    const OWN: usize = 3;
    const SHARED: usize = 5;
    const ERRORS: usize = 2;

    /// Returns blocks of weighted rows.
    fn blocks(rows: &[DMatrix<f64>], weight: fn(usize) -> f64) -> Vec<BlockNormal<OWN, SHARED>> {
        let weighted_rows = |rows: &DMatrix<f64>| {
            DMatrix::from_fn(rows.nrows(), rows.ncols(), |row, column| {
                rows[(row, column)] * weight(row).sqrt()
            })
        };
        rows.iter()
            .map(|rows| direct_rows(weighted_rows(rows)).normal())
            .collect()
    }

    /// Returns the whole matrix, shared parameters first.
    fn dense_matrix(
        blocks: &[BlockNormal<OWN, SHARED>],
        prior: &SVector<f64, SHARED>,
    ) -> DMatrix<f64> {
        let size = SHARED + OWN * blocks.len();
        let mut matrix = DMatrix::zeros(size, size);
        let mut shared = SMatrix::from_diagonal(prior);
        for (index, block) in blocks.iter().enumerate() {
            let offset = SHARED + OWN * index;
            shared += block.shared;
            matrix
                .view_mut((offset, offset), (OWN, OWN))
                .copy_from(&block.own);
            matrix
                .view_mut((offset, 0), (OWN, SHARED))
                .copy_from(&block.coupling);
            matrix
                .view_mut((0, offset), (SHARED, OWN))
                .copy_from(&block.coupling.transpose());
        }
        matrix.view_mut((0, 0), (SHARED, SHARED)).copy_from(&shared);
        matrix
    }

    /// Returns the effect of errors on the whole gradient, shared parameters first.
    fn error_gradient(rows: &[DMatrix<f64>]) -> DMatrix<f64> {
        let mut gradient = DMatrix::zeros(SHARED + OWN * rows.len(), ERRORS);
        for (index, rows) in rows.iter().enumerate() {
            let errors = rows.columns(1 + OWN + SHARED, ERRORS);
            let (own_slopes, shared_slopes) = (rows.columns(1, OWN), rows.columns(1 + OWN, SHARED));
            let mut shared_rows = gradient.rows_mut(0, SHARED);
            shared_rows += shared_slopes.tr_mul(&errors);
            let mut own_rows = gradient.rows_mut(SHARED + OWN * index, OWN);
            own_rows += own_slopes.tr_mul(&errors);
        }
        gradient
    }

    /// Compares with the scatter between two inverses of the whole matrix, including the effect of errors on the gradients.
    #[test]
    fn the_covariance_equals_that_of_the_dense_matrix() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let mut number = || -> f64 { StandardNormal.sample(&mut random) };
        let rows: Vec<_> = (0..3)
            .map(|_| DMatrix::from_fn(24, 1 + OWN + SHARED + ERRORS, |_, _| number()))
            .collect();
        let fit_columns = |rows: &DMatrix<f64>| rows.columns(0, 1 + OWN + SHARED).into_owned();
        let fit_rows: Vec<_> = rows.iter().map(fit_columns).collect();
        let prior = SVector::from_fn(|index, _| 0.3 + 0.2 * index as f64);
        let (normal, scatter) = (
            blocks(&fit_rows, |_| 1.0),
            blocks(&fit_rows, |i| 1.0 + i as f64),
        );
        let mut shared = SMatrix::from_diagonal(&prior);
        for block in &normal {
            shared += block.shared;
        }
        let minimum = ArrowMinimum {
            shared: SVector::zeros(),
            own: vec![SVector::zeros(); 3],
            squares: 0.0,
            converged: true,
            arrow: Arrow {
                squares: 0.0,
                blocks: normal.clone(),
                shared_gradient: SVector::zeros(),
                shared,
            },
        };
        // Each error moves a further parameter of the model.
        let mut by_error =
            OMatrix::<f64, Dyn, Const<ERRORS>>::zeros_generic(Dyn(OWN + SHARED + ERRORS), Const);
        by_error
            .view_mut((OWN + SHARED, 0), (ERRORS, ERRORS))
            .fill_with_identity();
        let all_rows: Vec<_> = rows.iter().cloned().map(direct_rows).collect();
        let response = minimum.response(&all_rows, &by_error).unwrap();
        let covariance = minimum
            .covariance::<ERRORS>(scatter.clone(), prior)
            .unwrap();
        let combination = ParameterPoint {
            shared: SVector::from_fn(|index, _| 1.0 - 0.3 * index as f64),
            own: (0..3)
                .map(|block| SVector::from_fn(|index, _| (block + index) as f64 - 1.5))
                .collect(),
        };
        let combination_covariance = minimum
            .combination_covariance(&covariance, &combination)
            .unwrap();
        let covariance = covariance.with_response(response);
        let inverse = dense_matrix(&normal, &prior).try_inverse().unwrap();
        let flatten = |place: &ParameterPoint<OWN, SHARED>| {
            let own_values = place.own.iter().flat_map(|values| values.iter());
            DVector::from_vec(place.shared.iter().chain(own_values).copied().collect())
        };
        let expected_combination =
            &inverse * dense_matrix(&scatter, &prior) * &inverse * flatten(&combination);
        assert!((flatten(&combination_covariance) - expected_combination).amax() < 1e-12);
        let gradient = error_gradient(&rows);
        let gradients = dense_matrix(&scatter, &prior) + &gradient * gradient.transpose();
        let expected = &inverse * gradients * &inverse;
        let max_difference = |a: DMatrix<f64>, b: DMatrix<f64>| (a - b).abs().max();
        let submatrix = |matrix: &DMatrix<f64>, start: (usize, usize), size: (usize, usize)| {
            matrix.view(start, size).into_owned()
        };
        let shared = DMatrix::from_column_slice(SHARED, SHARED, covariance.shared.as_slice());
        assert!(max_difference(shared, submatrix(&expected, (0, 0), (SHARED, SHARED))) < 1e-12);
        for (index, block) in covariance.blocks.iter().enumerate() {
            let offset = SHARED + OWN * index;
            let own_block = DMatrix::from_column_slice(OWN, OWN, block.own.as_slice());
            assert!(
                max_difference(
                    own_block,
                    submatrix(&expected, (offset, offset), (OWN, OWN))
                ) < 1e-12
            );
            let cross_block = DMatrix::from_column_slice(OWN, SHARED, block.cross.as_slice());
            assert!(
                max_difference(
                    cross_block,
                    submatrix(&expected, (offset, 0), (OWN, SHARED))
                ) < 1e-12
            );
        }
    }

    #[test]
    fn a_matrix_that_leaves_a_combination_open_has_no_inverse() {
        let singular = SMatrix::<f64, 2, 2>::new(1.0, 1.0, 1.0, 1.0);
        assert_eq!(inverse_of_normal(&singular), None);
        assert_eq!(inverse_of_normal(&SMatrix::<f64, 2, 2>::zeros()), None);
    }
}
