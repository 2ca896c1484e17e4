//! Covariance of a minimum, from the scatter of its residuals and from errors that no residual shows.

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::minimise::ArrowMinimum;
use crate::normal::{BlockNormal, Place};

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
        self.shared += response.shared * response.shared.transpose();
        for (block, own) in self.blocks.iter_mut().zip(&response.own) {
            block.own += own * own.transpose();
            block.with_shared += own * response.shared.transpose();
        }
        self.response = response;
        self
    }
}

/// Covariance of a block's own parameters, and of these with the shared ones.
pub struct BlockCovariance<const OWN: usize, const SHARED: usize> {
    /// Covariance of the own parameters.
    pub own: SMatrix<f64, OWN, OWN>,
    /// Covariance between own and shared parameters.
    pub with_shared: SMatrix<f64, OWN, SHARED>,
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
    fn none(blocks: usize) -> Self {
        Self {
            shared: SMatrix::zeros(),
            own: vec![SMatrix::zeros(); blocks],
        }
    }
}

impl<const OWN: usize, const SHARED: usize> ArrowMinimum<OWN, SHARED> {
    /// Returns the covariance of the parameters for gradients with the given `scatter` and `prior_scatter`: the scatter between
    /// two inverse normal matrices (Huber 1967), block by block. `None` if the data do not determine a combination of
    /// parameters.
    #[must_use]
    pub fn covariance<const ERRORS: usize>(
        &self,
        scatter: Vec<BlockNormal<OWN, SHARED>>,
        prior_scatter: SVector<f64, SHARED>,
    ) -> Option<ArrowCovariance<OWN, SHARED, ERRORS>> {
        let mut reduced = self.arrow.shared;
        let mut of_shared = SMatrix::from_diagonal(&prior_scatter);
        let mut eliminated = Vec::with_capacity(scatter.len());
        for (block, scatter) in self.arrow.blocks.iter().zip(&scatter) {
            let inverse = inverted(&block.own)?;
            let to_shared = inverse * block.coupling;
            reduced -= block.coupling.transpose() * to_shared;
            // Contribution of a block's gradient to the shared one, after its own parameters are eliminated.
            let across = scatter.coupling - scatter.own * to_shared;
            of_shared += scatter.shared
                - scatter.coupling.transpose() * to_shared
                - to_shared.transpose() * across;
            eliminated.push((inverse, to_shared, across));
        }
        let reduced = inverted(&reduced)?;
        let shared = reduced * of_shared * reduced;
        let blocks = eliminated
            .into_iter()
            .zip(&scatter)
            .map(|((inverse, to_shared, across), scatter)| {
                let direct = inverse * across * reduced;
                let mixed = direct * to_shared.transpose();
                BlockCovariance {
                    own: inverse * scatter.own * inverse
                        + to_shared * shared * to_shared.transpose()
                        - mixed
                        - mixed.transpose(),
                    with_shared: direct - to_shared * shared,
                }
            })
            .collect();
        Some(ArrowCovariance {
            shared,
            blocks,
            response: ArrowResponse::none(scatter.len()),
            scatter: (scatter, prior_scatter),
        })
    }

    /// Returns the covariance of a linear combination of all parameters with each of them, from the scatter behind
    /// `covariance`, without its response to errors.
    #[must_use]
    pub fn covariance_with<const ERRORS: usize>(
        &self,
        covariance: &ArrowCovariance<OWN, SHARED, ERRORS>,
        combination: &Place<OWN, SHARED>,
    ) -> Option<Place<OWN, SHARED>> {
        let (blocks, prior) = &covariance.scatter;
        let at = self.arrow.step(0.0, combination)?;
        let mut scattered = Place {
            shared: at.shared.component_mul(prior),
            own: Vec::with_capacity(blocks.len()),
        };
        for (block, own) in blocks.iter().zip(&at.own) {
            let of_own = block.own * own + block.coupling * at.shared;
            scattered.own.push(of_own);
            scattered.shared += block.coupling.tr_mul(own) + block.shared * at.shared;
        }
        self.arrow.step(0.0, &scattered)
    }

    /// Returns the response of the minimum to errors. The rows of each block are those of [`BlockNormal::of`], followed by the
    /// effect of each error on the block's residuals.
    #[must_use]
    pub fn response<const ERRORS: usize>(
        &self,
        rows: &[DMatrix<f64>],
    ) -> Option<ArrowResponse<OWN, SHARED, ERRORS>> {
        let mut response = ArrowResponse::<OWN, SHARED, ERRORS>::none(rows.len());
        for error in 0..ERRORS {
            let mut moved = Place {
                shared: SVector::zeros(),
                own: Vec::with_capacity(rows.len()),
            };
            for rows in rows {
                let by_error = rows.column(1 + OWN + SHARED + error);
                let (own, shared) = (
                    rows.fixed_columns::<OWN>(1),
                    rows.fixed_columns::<SHARED>(1 + OWN),
                );
                moved.own.push(own.tr_mul(&by_error));
                moved.shared += shared.tr_mul(&by_error);
            }
            let step = self.arrow.step(0.0, &moved)?;
            response.shared.set_column(error, &step.shared);
            for (of_block, own) in response.own.iter_mut().zip(step.own) {
                of_block.set_column(error, &own);
            }
        }
        Some(response)
    }
}

/// Pivot of a matrix scaled to unit diagonal below which it is rounding, not information.
const SINGULAR: f64 = 1e-12;

fn inverted<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let scale = SMatrix::<f64, N, N>::from_diagonal(&matrix.diagonal().map(|of| of.sqrt().recip()));
    let factor = (scale * matrix * scale).cholesky()?;
    let pivots = factor.l_dirty().diagonal();
    if !pivots.iter().all(|pivot| pivot.powi(2) >= SINGULAR) {
        return None;
    }
    Some(scale * factor.inverse() * scale)
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::normal::Arrow;

    const OWN: usize = 3;
    const SHARED: usize = 5;
    const ERRORS: usize = 2;

    /// Returns blocks of weighted rows.
    fn blocks(rows: &[DMatrix<f64>], weight: fn(usize) -> f64) -> Vec<BlockNormal<OWN, SHARED>> {
        let weighed = |rows: &DMatrix<f64>| {
            DMatrix::from_fn(rows.nrows(), rows.ncols(), |row, column| {
                rows[(row, column)] * weight(row).sqrt()
            })
        };
        rows.iter()
            .map(|rows| BlockNormal::of(&weighed(rows)))
            .collect()
    }

    /// Returns the whole matrix, shared parameters first.
    fn dense(blocks: &[BlockNormal<OWN, SHARED>], prior: &SVector<f64, SHARED>) -> DMatrix<f64> {
        let size = SHARED + OWN * blocks.len();
        let mut matrix = DMatrix::zeros(size, size);
        let mut shared = SMatrix::from_diagonal(prior);
        for (index, block) in blocks.iter().enumerate() {
            let at = SHARED + OWN * index;
            shared += block.shared;
            matrix.view_mut((at, at), (OWN, OWN)).copy_from(&block.own);
            matrix
                .view_mut((at, 0), (OWN, SHARED))
                .copy_from(&block.coupling);
            matrix
                .view_mut((0, at), (SHARED, OWN))
                .copy_from(&block.coupling.transpose());
        }
        matrix.view_mut((0, 0), (SHARED, SHARED)).copy_from(&shared);
        matrix
    }

    /// Returns the effect of errors on the whole gradient, shared parameters first.
    fn moved_gradient(rows: &[DMatrix<f64>]) -> DMatrix<f64> {
        let mut moved = DMatrix::zeros(SHARED + OWN * rows.len(), ERRORS);
        for (index, rows) in rows.iter().enumerate() {
            let errors = rows.columns(1 + OWN + SHARED, ERRORS);
            let (own, shared) = (rows.columns(1, OWN), rows.columns(1 + OWN, SHARED));
            let mut of_shared = moved.rows_mut(0, SHARED);
            of_shared += shared.tr_mul(&errors);
            let mut of_own = moved.rows_mut(SHARED + OWN * index, OWN);
            of_own += own.tr_mul(&errors);
        }
        moved
    }

    /// Compares with the scatter between two inverses of the whole matrix, including the effect of errors on the gradients.
    #[test]
    fn the_covariance_is_that_of_the_whole_matrix() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let mut number = || -> f64 { StandardNormal.sample(&mut random) };
        let rows: Vec<_> = (0..3)
            .map(|_| DMatrix::from_fn(24, 1 + OWN + SHARED + ERRORS, |_, _| number()))
            .collect();
        let of_block = |rows: &DMatrix<f64>| rows.columns(0, 1 + OWN + SHARED).into_owned();
        let summed: Vec<_> = rows.iter().map(of_block).collect();
        let prior = SVector::from_fn(|index, _| 0.3 + 0.2 * index as f64);
        let (normal, scatter) = (
            blocks(&summed, |_| 1.0),
            blocks(&summed, |i| 1.0 + i as f64),
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
        let response = minimum.response(&rows).unwrap();
        let found = minimum
            .covariance::<ERRORS>(scatter.clone(), prior)
            .unwrap();
        let combination = Place {
            shared: SVector::from_fn(|index, _| 1.0 - 0.3 * index as f64),
            own: (0..3)
                .map(|block| SVector::from_fn(|index, _| (block + index) as f64 - 1.5))
                .collect(),
        };
        let together = minimum.covariance_with(&found, &combination).unwrap();
        let found = found.with_response(response);
        let inverse = dense(&normal, &prior).try_inverse().unwrap();
        let in_line = |of: &Place<OWN, SHARED>| {
            let own = of.own.iter().flat_map(|own| own.iter());
            DVector::from_vec(of.shared.iter().chain(own).copied().collect())
        };
        let with_all = &inverse * dense(&scatter, &prior) * &inverse * in_line(&combination);
        assert!((in_line(&together) - with_all).amax() < 1e-12);
        let by_error = moved_gradient(&rows);
        let gradients = dense(&scatter, &prior) + &by_error * by_error.transpose();
        let expected = &inverse * gradients * &inverse;
        let apart = |ours: DMatrix<f64>, theirs: DMatrix<f64>| (ours - theirs).abs().max();
        let of = |matrix: &DMatrix<f64>, at: (usize, usize), size: (usize, usize)| {
            matrix.view(at, size).into_owned()
        };
        let shared = DMatrix::from_column_slice(SHARED, SHARED, found.shared.as_slice());
        assert!(apart(shared, of(&expected, (0, 0), (SHARED, SHARED))) < 1e-12);
        for (index, block) in found.blocks.iter().enumerate() {
            let at = SHARED + OWN * index;
            let own = DMatrix::from_column_slice(OWN, OWN, block.own.as_slice());
            assert!(apart(own, of(&expected, (at, at), (OWN, OWN))) < 1e-12);
            let with = DMatrix::from_column_slice(OWN, SHARED, block.with_shared.as_slice());
            assert!(apart(with, of(&expected, (at, 0), (OWN, SHARED))) < 1e-12);
        }
    }

    #[test]
    fn a_matrix_that_leaves_a_combination_open_has_no_inverse() {
        let open = SMatrix::<f64, 2, 2>::new(1.0, 1.0, 1.0, 1.0);
        assert_eq!(inverted(&open), None);
        assert_eq!(inverted(&SMatrix::<f64, 2, 2>::zeros()), None);
    }
}
