//! Least squares in which each block of residuals has parameters of its own and shares others with all blocks: the normal
//! matrix has the shape of an arrow, and a step costs as much as the number of blocks.

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::calibration_errors::{ByError, ERRORS};

/// Number of parameters that a block has of its own.
pub(super) const OWN: usize = 7;
/// Number of parameters that all blocks share.
pub(super) const SHARED: usize = 16;

type Own = SVector<f64, OWN>;
type Shared = SVector<f64, SHARED>;
type OwnMatrix = SMatrix<f64, OWN, OWN>;
type SharedMatrix = SMatrix<f64, SHARED, SHARED>;
type Coupling = SMatrix<f64, OWN, SHARED>;

/// Gradient and normal matrix of a block's half sum of squares.
#[derive(Clone, Default)]
pub(super) struct BlockNormal {
    pub(super) squares: f64,
    pub(super) own_gradient: Own,
    pub(super) shared_gradient: Shared,
    pub(super) own: OwnMatrix,
    pub(super) coupling: Coupling,
    pub(super) shared: SharedMatrix,
}

impl BlockNormal {
    /// Sums over rows of a residual, its slopes by the block's own parameters, and by the shared ones.
    pub(super) fn of(columns: &DMatrix<f64>) -> Self {
        let residual = columns.column(0);
        let own = columns.fixed_columns::<OWN>(1);
        let shared = columns.fixed_columns::<SHARED>(1 + OWN);
        Self {
            squares: residual.norm_squared(),
            own_gradient: own.tr_mul(&residual),
            shared_gradient: shared.tr_mul(&residual),
            own: own.tr_mul(&own),
            coupling: own.tr_mul(&shared),
            shared: shared.tr_mul(&shared),
        }
    }
}

/// A least-squares problem with the shape of an arrow.
pub(super) trait ArrowProblem {
    /// Returns each block at the parameters; `None` out of the model's domain. The sums are in one unit for all.
    fn blocks(&mut self, shared: &Shared, own: &[Own]) -> Option<Vec<BlockNormal>>;
    /// Returns squares, gradient and diagonal of what is known of the shared parameters beforehand.
    fn prior(&self, shared: &Shared) -> (f64, Shared, Shared);
}

/// A minimum, or the best that was found.
#[derive(Clone)]
pub(super) struct ArrowMinimum {
    pub(super) shared: Shared,
    pub(super) own: Vec<Own>,
    /// Sum of squares, with the prior.
    pub(super) squares: f64,
    /// Whether it is a minimum.
    pub(super) converged: bool,
    /// The normal matrix at it.
    normal: Arrow,
}

const ITERATIONS: usize = 500;
const FIRST_DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e12;
/// Relative decrease of the squares that ends the search.
const TOLERANCE: f64 = 1e-7;

#[derive(Clone)]
struct Arrow {
    squares: f64,
    blocks: Vec<BlockNormal>,
    shared_gradient: Shared,
    shared: SharedMatrix,
}

impl Arrow {
    fn of(problem: &mut impl ArrowProblem, shared: &Shared, own: &[Own]) -> Option<Self> {
        let blocks = problem.blocks(shared, own)?;
        let (mut squares, mut gradient, diagonal) = problem.prior(shared);
        let mut matrix = SharedMatrix::from_diagonal(&diagonal);
        for block in &blocks {
            squares += block.squares;
            gradient += block.shared_gradient;
            matrix += block.shared;
        }
        squares.is_finite().then_some(Self {
            squares,
            blocks,
            shared_gradient: gradient,
            shared: matrix,
        })
    }

    /// Returns the damped Gauss–Newton step, by eliminating each block's own parameters.
    fn step(&self, damping: f64) -> Option<(Shared, Vec<Own>)> {
        let damped = |diagonal: f64| diagonal * damping;
        let mut reduced =
            self.shared + SharedMatrix::from_diagonal(&self.shared.diagonal().map(damped));
        let mut right = -self.shared_gradient;
        let mut eliminated = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let own = block.own + OwnMatrix::from_diagonal(&block.own.diagonal().map(damped));
            let factor = own.cholesky()?;
            let (to_shared, to_gradient) = (
                factor.solve(&block.coupling),
                factor.solve(&block.own_gradient),
            );
            reduced -= block.coupling.transpose() * to_shared;
            right += block.coupling.transpose() * to_gradient;
            eliminated.push((to_shared, to_gradient));
        }
        let shared = reduced.cholesky()?.solve(&right);
        let own = eliminated
            .into_iter()
            .map(|(to_shared, to_gradient)| -to_gradient - to_shared * shared)
            .collect();
        Some((shared, own))
    }

    /// Returns by how much the squares should fall with a step.
    fn expected_fall(&self, shared: &Shared, own: &[Own]) -> f64 {
        let mut fall =
            -2.0 * self.shared_gradient.dot(shared) - shared.dot(&(self.shared * shared));
        for (block, own) in self.blocks.iter().zip(own) {
            fall -= 2.0 * block.own_gradient.dot(own)
                + own.dot(&(block.own * own))
                + 2.0 * own.dot(&(block.coupling * shared));
        }
        fall
    }
}

/// Minimises by Levenberg–Marquardt from one start; `None` if the model does not hold there.
pub(super) fn minimise(
    problem: &mut impl ArrowProblem,
    mut shared: Shared,
    mut own: Vec<Own>,
) -> Option<ArrowMinimum> {
    let mut arrow = Arrow::of(problem, &shared, &own)?;
    let (mut damping, mut growth, mut converged) = (FIRST_DAMPING, 2.0, false);
    for _ in 0..ITERATIONS {
        let Some((shared_step, own_steps)) = arrow.step(damping) else {
            damping *= growth;
            growth *= 2.0;
            if damping > MOST_DAMPING {
                break;
            }
            continue;
        };
        let expected = arrow.expected_fall(&shared_step, &own_steps);
        if expected <= TOLERANCE * arrow.squares {
            converged = true;
            break;
        }
        let tried_shared = shared + shared_step;
        let tried: Vec<Own> = own
            .iter()
            .zip(&own_steps)
            .map(|(at, step)| at + step)
            .collect();
        let next = Arrow::of(problem, &tried_shared, &tried);
        match next.filter(|next| next.squares < arrow.squares) {
            Some(next) => {
                let gain = (arrow.squares - next.squares) / expected;
                (shared, own, arrow) = (tried_shared, tried, next);
                damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
            }
            None => {
                damping *= growth;
                growth *= 2.0;
                // No step however small makes it less: what remains is rounding.
                if damping > MOST_DAMPING {
                    converged = true;
                    break;
                }
            }
        }
    }
    Some(ArrowMinimum {
        shared,
        own,
        squares: arrow.squares,
        converged,
        normal: arrow,
    })
}

/// Covariance of the shared parameters, and of each block's own with the shared ones.
pub(super) struct ArrowCovariance {
    pub(super) shared: SharedMatrix,
    pub(super) blocks: Vec<BlockCovariance>,
    /// What of it follows errors.
    pub(super) response: ArrowResponse,
}

impl ArrowCovariance {
    /// Returns it with what errors do that the minimum follows.
    pub(super) fn with_response(mut self, response: ArrowResponse) -> Self {
        self.shared += response.shared * response.shared.transpose();
        for (block, own) in self.blocks.iter_mut().zip(&response.own) {
            block.own += own * own.transpose();
            block.with_shared += own * response.shared.transpose();
        }
        self.response = response;
        self
    }
}

/// Covariance of a block's own parameters, and between them and the shared ones.
pub(super) struct BlockCovariance {
    pub(super) own: OwnMatrix,
    pub(super) with_shared: Coupling,
}

impl ArrowMinimum {
    /// Returns the covariance of the parameters, where the gradients scatter as `scatter` and `prior_scatter` say: the inverse
    /// of the normal matrix on both sides of them (Huber 1967), block by block. `None` if the data leave a combination of
    /// parameters open.
    pub(super) fn covariance(
        &self,
        scatter: &[BlockNormal],
        prior_scatter: &Shared,
    ) -> Option<ArrowCovariance> {
        let mut reduced = self.normal.shared;
        let mut of_shared = SharedMatrix::from_diagonal(prior_scatter);
        let mut eliminated = Vec::with_capacity(scatter.len());
        for (block, scatter) in self.normal.blocks.iter().zip(scatter) {
            let inverse = inverted(&block.own)?;
            let to_shared = inverse * block.coupling;
            reduced -= block.coupling.transpose() * to_shared;
            // What a block's gradient adds to the shared one once its own parameters have followed.
            let across = scatter.coupling - scatter.own * to_shared;
            of_shared += scatter.shared
                - scatter.coupling.transpose() * to_shared
                - to_shared.transpose() * across;
            eliminated.push((inverse, to_shared, across));
        }
        let reduced = inverted(&reduced)?;
        let shared = reduced * of_shared * reduced;
        let response = ArrowResponse::none(scatter.len());
        let blocks = eliminated
            .into_iter()
            .zip(scatter)
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
            response,
        })
    }
}

/// How a minimum follows errors that are not fitted: the shared parameters, and each block's own.
pub(super) struct ArrowResponse {
    pub(super) shared: ByError<SHARED>,
    pub(super) own: Vec<ByError<OWN>>,
}

impl ArrowResponse {
    fn none(blocks: usize) -> Self {
        Self {
            shared: ByError::zeros(),
            own: vec![ByError::zeros(); blocks],
        }
    }
}

impl ArrowMinimum {
    /// Returns how the minimum follows errors. The columns of each block are those of [`BlockNormal::of`], and after them what
    /// each error does to the block's residuals.
    pub(super) fn response(&self, columns: &[DMatrix<f64>]) -> Option<ArrowResponse> {
        let mut response = ArrowResponse::none(columns.len());
        for error in 0..ERRORS {
            let mut arrow = self.normal.clone();
            arrow.shared_gradient = Shared::zeros();
            for (block, columns) in arrow.blocks.iter_mut().zip(columns) {
                let moved = columns.column(1 + OWN + SHARED + error);
                block.own_gradient = columns.fixed_columns::<OWN>(1).tr_mul(&moved);
                arrow.shared_gradient += columns.fixed_columns::<SHARED>(1 + OWN).tr_mul(&moved);
            }
            let (shared, own) = arrow.step(0.0)?;
            response.shared.set_column(error, &shared);
            for (of_block, own) in response.own.iter_mut().zip(own) {
                of_block.set_column(error, &own);
            }
        }
        Some(response)
    }
}

/// A pivot of a matrix that is scaled to unit diagonal below this is rounding, not information.
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
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Blocks of rows, each weighed.
    fn blocks(rows: &[DMatrix<f64>], weight: fn(usize) -> f64) -> Vec<BlockNormal> {
        let weighed = |rows: &DMatrix<f64>| {
            DMatrix::from_fn(rows.nrows(), rows.ncols(), |row, column| {
                rows[(row, column)] * weight(row).sqrt()
            })
        };
        rows.iter()
            .map(|rows| BlockNormal::of(&weighed(rows)))
            .collect()
    }

    /// The whole matrix, shared parameters first.
    fn dense(blocks: &[BlockNormal], prior: &Shared) -> DMatrix<f64> {
        let size = SHARED + OWN * blocks.len();
        let mut matrix = DMatrix::zeros(size, size);
        let mut shared = SharedMatrix::from_diagonal(prior);
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

    /// How errors move the whole gradient, shared parameters first.
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

    /// Against the inverse of the whole matrix on both sides of the whole scatter, with what errors do to the gradients.
    #[test]
    fn the_covariance_is_that_of_the_whole_matrix() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let mut number = || -> f64 { StandardNormal.sample(&mut random) };
        let rows: Vec<_> = (0..3)
            .map(|_| DMatrix::from_fn(24, 1 + OWN + SHARED + ERRORS, |_, _| number()))
            .collect();
        let prior = Shared::from_fn(|index, _| 0.3 + 0.2 * (index % 7) as f64);
        let (normal, scatter) = (blocks(&rows, |_| 1.0), blocks(&rows, |i| 1.0 + i as f64));
        let mut shared = SharedMatrix::from_diagonal(&prior);
        for block in &normal {
            shared += block.shared;
        }
        let minimum = ArrowMinimum {
            shared: Shared::zeros(),
            own: vec![Own::zeros(); 3],
            squares: 0.0,
            converged: true,
            normal: Arrow {
                squares: 0.0,
                blocks: normal.clone(),
                shared_gradient: Shared::zeros(),
                shared,
            },
        };
        let response = minimum.response(&rows).unwrap();
        let found = minimum
            .covariance(&scatter, &prior)
            .unwrap()
            .with_response(response);
        let inverse = dense(&normal, &prior).try_inverse().unwrap();
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
