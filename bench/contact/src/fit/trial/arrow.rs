//! Least squares in which each block of residuals has parameters of its own and shares others with all blocks: the normal
//! matrix has the shape of an arrow, and a step costs as much as the number of blocks.

use nalgebra::{DMatrix, SMatrix, SVector};
use num_complex::Complex64;

use super::super::least_squares::invert_scaled;

/// Number of parameters that a block has of its own.
pub(super) const OWN: usize = 5;
/// Number of parameters that all blocks share.
pub(super) const SHARED: usize = 4;

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
    /// Adds a complex residual with its slopes.
    pub(super) fn add(
        &mut self,
        residual: Complex64,
        by_own: &[Complex64; OWN],
        by_shared: &[Complex64; SHARED],
        weight: f64,
    ) {
        let real = |of: Complex64, with: Complex64| (of.conj() * with).re * weight;
        self.squares += residual.norm_sqr() * weight;
        for (row, &slope) in by_own.iter().enumerate() {
            self.own_gradient[row] += real(slope, residual);
            for (column, &other) in by_own.iter().enumerate() {
                self.own[(row, column)] += real(slope, other);
            }
            for (column, &other) in by_shared.iter().enumerate() {
                self.coupling[(row, column)] += real(slope, other);
            }
        }
        for (row, &slope) in by_shared.iter().enumerate() {
            self.shared_gradient[row] += real(slope, residual);
            for (column, &other) in by_shared.iter().enumerate() {
                self.shared[(row, column)] += real(slope, other);
            }
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

const ITERATIONS: usize = 200;
const FIRST_DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e12;
/// Relative decrease of the squares that ends the search.
const TOLERANCE: f64 = 1e-11;

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

impl ArrowMinimum {
    /// Returns the inverse of the normal matrix, the shared parameters first and then each block's own; `None` if the data leave
    /// a combination of parameters open.
    pub(super) fn inverse(&self) -> Option<DMatrix<f64>> {
        let Arrow { blocks, shared, .. } = &self.normal;
        invert_scaled(&dense(shared, blocks))
    }
}

/// Returns an arrow as a matrix, the shared parameters first and then each block's own.
pub(super) fn dense(shared: &SharedMatrix, blocks: &[BlockNormal]) -> DMatrix<f64> {
    let size = SHARED + OWN * blocks.len();
    let mut matrix = DMatrix::zeros(size, size);
    matrix
        .fixed_view_mut::<SHARED, SHARED>(0, 0)
        .copy_from(shared);
    for (index, block) in blocks.iter().enumerate() {
        let at = own_at(index);
        matrix
            .fixed_view_mut::<OWN, OWN>(at, at)
            .copy_from(&block.own);
        matrix
            .fixed_view_mut::<OWN, SHARED>(at, 0)
            .copy_from(&block.coupling);
        matrix
            .fixed_view_mut::<SHARED, OWN>(0, at)
            .copy_from(&block.coupling.transpose());
    }
    matrix
}

/// Returns where a block's own parameters begin.
pub(super) fn own_at(block: usize) -> usize {
    SHARED + OWN * block
}
