//! Normal matrix in the shape of an arrow: one block per block of residuals, and one for the shared parameters.
//!
//! With the Jacobians J_b and K_b of the residuals r_b of block b by its own and by the shared parameters, and o_b = J_bᵀJ_b,
//! c_b = J_bᵀK_b, s = Σ K_bᵀK_b (priors add their precisions to the diagonals), a Gauss–Newton step (δ_b, ε) solves
//!
//! ```text
//! o_b δ_b + c_b ε = −J_bᵀr_b       for each b
//! Σ c_bᵀδ_b + s ε = −Σ K_bᵀr_b
//! ```
//!
//! The first line gives δ_b = −o_b⁻¹J_bᵀr_b − o_b⁻¹c_b ε. In the second line that leaves only the shared parameters:
//! (s − Σ c_bᵀo_b⁻¹c_b) ε = −Σ K_bᵀr_b + Σ c_bᵀo_b⁻¹J_bᵀr_b. The matrix on the left is the Schur complement.

use nalgebra::{SMatrix, SVector};

/// Gradient and normal matrix of half a block's sum of squares.
#[derive(Debug, Clone)]
pub struct BlockNormal<const OWN: usize, const SHARED: usize> {
    /// Sum of squares.
    pub squares: f64,
    /// Gradient by the block's own parameters.
    pub own_gradient: SVector<f64, OWN>,
    /// Gradient by the shared parameters.
    pub shared_gradient: SVector<f64, SHARED>,
    /// Normal matrix of the own parameters.
    pub own: SMatrix<f64, OWN, OWN>,
    /// Normal matrix between own and shared parameters.
    pub coupling: SMatrix<f64, OWN, SHARED>,
    /// Normal matrix of the shared parameters.
    pub shared: SMatrix<f64, SHARED, SHARED>,
}

/// A point or a step in the space of all parameters.
#[derive(Debug, Clone)]
pub struct ParameterPoint<const OWN: usize, const SHARED: usize> {
    /// Values of the shared parameters.
    pub shared: SVector<f64, SHARED>,
    /// Values of each block's own parameters.
    pub own: Vec<SVector<f64, OWN>>,
}

impl<const OWN: usize, const SHARED: usize> ParameterPoint<OWN, SHARED> {
    /// Returns the inner product with a row or a place over all parameters.
    #[must_use]
    pub fn dot(&self, other: &Self) -> f64 {
        let pairs = self.own.iter().zip(&other.own);
        self.shared.dot(&other.shared) + pairs.map(|(a, b)| a.dot(b)).sum::<f64>()
    }

    /// Returns this place moved by `fraction` of a step.
    pub(crate) fn advance(&self, fraction: f64, step: &Self) -> Self {
        let pairs = self.own.iter().zip(&step.own);
        Self {
            shared: self.shared + step.shared * fraction,
            own: pairs.map(|(value, step)| value + step * fraction).collect(),
        }
    }
}

/// Damping that keeps a normal matrix regular without shortening the step.
const MIN_DAMPING: f64 = 1e-12;

/// Sums over all blocks, with the priors.
#[derive(Debug, Clone)]
pub(crate) struct Arrow<const OWN: usize, const SHARED: usize> {
    pub(crate) squares: f64,
    pub(crate) blocks: Vec<BlockNormal<OWN, SHARED>>,
    pub(crate) shared_gradient: SVector<f64, SHARED>,
    pub(crate) shared: SMatrix<f64, SHARED, SHARED>,
}

impl<const OWN: usize, const SHARED: usize> Arrow<OWN, SHARED> {
    /// Returns the gradient, which lies in the space of steps.
    pub(crate) fn gradient(&self) -> ParameterPoint<OWN, SHARED> {
        ParameterPoint {
            shared: self.shared_gradient,
            own: self.blocks.iter().map(|block| block.own_gradient).collect(),
        }
    }

    /// Returns the damped Gauss–Newton step down a gradient, by eliminating each block's own parameters. Damping λ multiplies
    /// the diagonals of o_b and s by 1 + λ (Marquardt 1963).
    pub(crate) fn step(
        &self,
        damping: f64,
        gradient: &ParameterPoint<OWN, SHARED>,
    ) -> Option<ParameterPoint<OWN, SHARED>> {
        let increment = |diagonal: f64| diagonal * damping;
        let mut schur =
            self.shared + SMatrix::from_diagonal(&self.shared.diagonal().map(increment));
        let mut right_side = -gradient.shared;
        let mut responses = Vec::with_capacity(self.blocks.len());
        for (block, own_gradient) in self.blocks.iter().zip(&gradient.own) {
            let normal = block.own + SMatrix::from_diagonal(&block.own.diagonal().map(increment));
            let factor = normal.cholesky()?;
            let (shared_response, gradient_response) =
                (factor.solve(&block.coupling), factor.solve(own_gradient));
            schur -= block.coupling.transpose() * shared_response;
            right_side += block.coupling.transpose() * gradient_response;
            responses.push((shared_response, gradient_response));
        }
        let shared = schur.cholesky()?.solve(&right_side);
        let own_steps = responses
            .into_iter()
            .map(|(shared_response, gradient_response)| {
                -gradient_response - shared_response * shared
            })
            .collect();
        Some(ParameterPoint {
            shared,
            own: own_steps,
        })
    }

    /// Returns the predicted decrease of the squares for a step.
    pub(crate) fn expected_fall(&self, step: &ParameterPoint<OWN, SHARED>) -> f64 {
        // Of |r + J δ|² = |r|² + 2 gᵀδ + δᵀN δ: the fall is −2 gᵀδ − δᵀN δ, with N undamped.
        let shared = &step.shared;
        let mut fall =
            -2.0 * self.shared_gradient.dot(shared) - shared.dot(&(self.shared * shared));
        for (block, own_step) in self.blocks.iter().zip(&step.own) {
            fall -= 2.0 * block.own_gradient.dot(own_step)
                + own_step.dot(&(block.own * own_step))
                + 2.0 * own_step.dot(&(block.coupling * shared));
        }
        fall
    }

    /// Returns the predicted decrease of the squares for an undamped step; infinite if no such step exists.
    pub(crate) fn undamped_fall(&self) -> f64 {
        let step = self.step(MIN_DAMPING, &self.gradient());
        step.map_or(f64::INFINITY, |step| self.expected_fall(&step))
    }

    /// Returns the squared length of a step, each parameter scaled by the diagonal of the normal matrix.
    pub(crate) fn length2(&self, step: &ParameterPoint<OWN, SHARED>) -> f64 {
        let blocks = self.blocks.iter().zip(&step.own);
        let own_length2: f64 = blocks
            .map(|(block, own_step)| own_step.component_mul(own_step).dot(&block.own.diagonal()))
            .sum();
        let shared_squares = step.shared.component_mul(&step.shared);
        own_length2 + shared_squares.dot(&self.shared.diagonal())
    }
}
