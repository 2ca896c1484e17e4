//! Levenberg–Marquardt search for the least squares, with steps that follow the bend of the valley (geodesic acceleration:
//! Transtrum & Sethna 2012). Parameters that the data hardly separate make narrow, bent valleys, in which straight steps are
//! short.
//!
//! Minimised is C(θ) = Σ r² + Σ p (θ − m)², with prior means m and precisions p; N is half its Gauss–Newton Hessian and g
//! half its gradient. One iteration:
//!
//! ```text
//! v = −(N + λ diag N)⁻¹ g                       Levenberg–Marquardt
//! a = −(N + λ diag N)⁻¹ Jᵀr″                    geodesic acceleration, r″ = d²r(θ + h v)/dh² at h = 0
//! θ ← θ + v + a/2                               if C falls
//! ```
//!
//! The term a/2 is left out where 2|a| ≥ 0.75 |v|, or where v is predicted to lower C by less than 10⁻⁴ C.
//!
//! λ follows Nielsen (1999): with the gain ρ, the fall of C relative to the −2 gᵀv − vᵀN v that was predicted, λ is
//! multiplied by max(1/3, 1 − (2ρ − 1)³) after a step that is taken, and by 2, 4, 8 … after steps in a row that are not.
//! Without damping the predicted fall is gᵀN⁻¹g, the square of the distance to the minimum in standard errors where residuals
//! have unit variance.

use nalgebra::{DVector, SMatrix, SVector};

use crate::block_rows::BlockRows;
use crate::normal::{Arrow, BlockNormal, ParameterPoint};

/// Independent normal priors of parameters. A precision (1/σ²) of 0 means no prior knowledge.
#[derive(Debug, Clone, Copy)]
pub struct Prior<const N: usize> {
    /// Means.
    pub mean: SVector<f64, N>,
    /// Inverse variances.
    pub precision: SVector<f64, N>,
}

impl<const N: usize> Prior<N> {
    /// Returns the prior's squares and gradient at the parameters.
    fn evaluate(&self, parameters: &SVector<f64, N>) -> (f64, SVector<f64, N>) {
        let deviation = parameters - self.mean;
        let gradient = deviation.component_mul(&self.precision);
        (deviation.dot(&gradient), gradient)
    }
}

/// A least-squares problem with the shape of an arrow.
pub trait ArrowProblem<const OWN: usize, const SHARED: usize> {
    /// Returns each block's residuals at the parameters with their slopes. `None` outside the model's domain.
    fn rows(
        &mut self,
        shared: &SVector<f64, SHARED>,
        own: &[SVector<f64, OWN>],
    ) -> Option<Vec<BlockRows<OWN, SHARED>>>;

    /// Returns the residuals of each block without slopes.
    fn residuals(
        &mut self,
        shared: &SVector<f64, SHARED>,
        own: &[SVector<f64, OWN>],
    ) -> Option<Vec<DVector<f64>>>;

    /// Returns the prior of a block's own parameters.
    fn own_prior(&self, block: usize) -> Prior<OWN>;

    /// Returns the prior of the shared parameters.
    fn shared_prior(&self) -> Prior<SHARED>;
}

/// Termination of a search.
#[derive(Debug, Clone, Copy)]
pub struct Termination {
    /// Relative decrease of the squares below which a step is not taken.
    pub tolerance: f64,
    /// Largest number of steps tried.
    pub iterations: usize,
}

/// A minimum, or the best point found.
#[derive(Debug, Clone)]
pub struct ArrowMinimum<const OWN: usize, const SHARED: usize> {
    /// The shared parameters.
    pub shared: SVector<f64, SHARED>,
    /// Each block's own parameters.
    pub own: Vec<SVector<f64, OWN>>,
    /// Sum of squares, including the prior.
    pub squares: f64,
    /// Whether it is a minimum.
    pub converged: bool,
    /// Gradient and normal matrix at the minimum.
    pub(crate) arrow: Arrow<OWN, SHARED>,
}

const FIRST_DAMPING: f64 = 1e-4;
const MAX_DAMPING: f64 = 1e12;
/// Fraction of a step at which the bend of the valley is evaluated.
const BEND_FRACTION: f64 = 0.1;
/// A bend longer than this fraction of its step is rejected (Transtrum & Sethna 2012).
const MAX_BEND: f64 = 0.75;
/// Relative decrease of the squares below which a step is too short to bend.
const MIN_BENDING_FALL: f64 = 1e-4;
/// Largest decrease predicted for an undamped step at a minimum, in units of the tolerance. A damped step cannot confirm a
/// minimum: with enough damping its predicted decrease vanishes anywhere.
const MAX_FALL_AT_MINIMUM: f64 = 1000.0;
/// Largest decrease predicted for an undamped step if no step reduces the squares, in units of the contribution of a single
/// residual: such a step moves no parameter by a thirtieth of its standard error.
const MAX_FALL_OF_ROUNDING: f64 = 1e-3;
/// Fraction of the initial squares below which a difference of squares is rounding.
const ROUNDING: f64 = 1e-20;

/// Minimises from one start; `None` if it lies outside the model's domain.
pub fn minimise<const OWN: usize, const SHARED: usize>(
    problem: &mut impl ArrowProblem<OWN, SHARED>,
    shared: SVector<f64, SHARED>,
    own: Vec<SVector<f64, OWN>>,
    termination: Termination,
) -> Option<ArrowMinimum<OWN, SHARED>> {
    let mut point = ParameterPoint { shared, own };
    let mut valley = Valley::new(problem, &point)?;
    let start_squares = valley.arrow.squares;
    let (mut damping, mut growth, mut converged) = (FIRST_DAMPING, 2.0, false);
    for _ in 0..termination.iterations {
        let arrow = &valley.arrow;
        let Some(step) = arrow.step(damping, &arrow.gradient()) else {
            damping *= growth;
            growth *= 2.0;
            if damping > MAX_DAMPING {
                break;
            }
            continue;
        };
        let expected = arrow.expected_fall(&step);
        let min_fall = termination.tolerance * arrow.squares;
        if expected <= min_fall && arrow.undamped_fall() <= MAX_FALL_AT_MINIMUM * min_fall {
            converged = true;
            break;
        }
        let mut candidate = point.advance(1.0, &step);
        if expected > MIN_BENDING_FALL * arrow.squares
            && let Some(bend) = valley.bend(problem, damping, &point, &step)
        {
            candidate = candidate.advance(1.0, &bend);
        }
        let next = Valley::new(problem, &candidate);
        match next.filter(|next| next.arrow.squares < arrow.squares) {
            Some(next) => {
                let gain = (arrow.squares - next.arrow.squares) / expected;
                (point, valley) = (candidate, next);
                damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
            }
            None => {
                damping *= growth;
                growth *= 2.0;
                // No step reduces the squares: the rest is rounding, or the search has reached the edge of the model's
                // domain.
                if damping > MAX_DAMPING {
                    let mean_square = valley.arrow.squares / valley.residuals().max(1) as f64;
                    let rounding =
                        (MAX_FALL_OF_ROUNDING * mean_square).max(ROUNDING * start_squares);
                    converged = valley.arrow.undamped_fall() <= rounding;
                    break;
                }
            }
        }
    }
    Some(ArrowMinimum {
        shared: point.shared,
        own: point.own,
        squares: valley.arrow.squares,
        converged,
        arrow: valley.arrow,
    })
}

/// State of a search.
struct Valley<const OWN: usize, const SHARED: usize> {
    arrow: Arrow<OWN, SHARED>,
    rows: Vec<BlockRows<OWN, SHARED>>,
}

impl<const OWN: usize, const SHARED: usize> Valley<OWN, SHARED> {
    fn new(
        problem: &mut impl ArrowProblem<OWN, SHARED>,
        point: &ParameterPoint<OWN, SHARED>,
    ) -> Option<Self> {
        let rows = problem.rows(&point.shared, &point.own)?;
        let mut blocks: Vec<BlockNormal<OWN, SHARED>> =
            rows.iter().map(BlockRows::normal).collect();
        let prior = problem.shared_prior();
        let (mut squares, mut shared_gradient) = prior.evaluate(&point.shared);
        let mut shared = SMatrix::from_diagonal(&prior.precision);
        for (index, (block, own)) in blocks.iter_mut().zip(&point.own).enumerate() {
            let prior = problem.own_prior(index);
            let (prior_squares, gradient) = prior.evaluate(own);
            block.squares += prior_squares;
            block.own_gradient += gradient;
            block.own += SMatrix::from_diagonal(&prior.precision);
            squares += block.squares;
            shared_gradient += block.shared_gradient;
            shared += block.shared;
        }
        let arrow = Arrow {
            squares,
            blocks,
            shared_gradient,
            shared,
        };
        squares.is_finite().then_some(Self { arrow, rows })
    }

    /// Returns the number of residuals.
    fn residuals(&self) -> usize {
        self.rows.iter().map(BlockRows::len).sum()
    }

    /// Returns the bend of a step: half its second derivative along the valley, from the second derivative of the residuals
    /// along the step. `None` if it is not small relative to the step.
    fn bend(
        &self,
        problem: &mut impl ArrowProblem<OWN, SHARED>,
        damping: f64,
        point: &ParameterPoint<OWN, SHARED>,
        step: &ParameterPoint<OWN, SHARED>,
    ) -> Option<ParameterPoint<OWN, SHARED>> {
        let probe = point.advance(BEND_FRACTION, step);
        let probe_residuals = problem.residuals(&probe.shared, &probe.own)?;
        let mut gradient = ParameterPoint {
            shared: SVector::zeros(),
            own: Vec::with_capacity(probe_residuals.len()),
        };
        for ((rows, residuals), own) in self.rows.iter().zip(&probe_residuals).zip(&step.own) {
            // The residuals of the priors are linear and have no r″.
            let (own_gradient, shared_gradient) =
                rows.bend_gradient((own, &step.shared), BEND_FRACTION, residuals);
            gradient.own.push(own_gradient);
            gradient.shared += shared_gradient;
        }
        let acceleration = self.arrow.step(damping, &gradient)?;
        // 2 |a|/|v| in the metric of diag N (Transtrum & Sethna 2012).
        let ratio = 2.0 * (self.arrow.length2(&acceleration) / self.arrow.length2(step)).sqrt();
        let half = |values: &SVector<f64, OWN>| values * 0.5;
        (ratio < MAX_BEND).then(|| ParameterPoint {
            shared: acceleration.shared * 0.5,
            own: acceleration.own.iter().map(half).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::block_rows::tests::direct_rows;

    const FLAT: Prior<1> = Prior {
        mean: SVector::<f64, 1>::new(0.0),
        precision: SVector::<f64, 1>::new(0.0),
    };

    /// Rosenbrock's valley in each block: y of the block follows the shared x², and x tends to 1.
    struct RosenbrockValley {
        narrowness: f64,
    }

    impl ArrowProblem<1, 1> for RosenbrockValley {
        fn rows(
            &mut self,
            shared: &SVector<f64, 1>,
            own: &[SVector<f64, 1>],
        ) -> Option<Vec<BlockRows<1, 1>>> {
            let narrowness = self.narrowness;
            let slopes = [narrowness, 0.0, -2.0 * narrowness * shared[0], 1.0];
            let residuals = self.residuals(shared, own)?;
            let block_rows = |block: DVector<f64>| {
                let rows = [&[block[0], block[1]], &slopes[..]].concat();
                direct_rows(DMatrix::from_column_slice(2, 3, &rows))
            };
            Some(residuals.into_iter().map(block_rows).collect())
        }

        fn residuals(
            &mut self,
            shared: &SVector<f64, 1>,
            own: &[SVector<f64, 1>],
        ) -> Option<Vec<DVector<f64>>> {
            let x = shared[0];
            let residuals_at =
                |y: &SVector<f64, 1>| vec![self.narrowness * (y[0] - x * x), x - 1.0];
            Some(own.iter().map(|y| residuals_at(y).into()).collect())
        }

        fn own_prior(&self, _: usize) -> Prior<1> {
            FLAT
        }

        fn shared_prior(&self) -> Prior<1> {
            FLAT
        }
    }

    const TERMINATION: Termination = Termination {
        tolerance: 1e-12,
        iterations: 500,
    };

    #[test]
    fn a_narrow_bent_valley_is_followed_to_its_end() {
        for narrowness in [1.0, 10.0, 1e3] {
            let mut problem = RosenbrockValley { narrowness };
            let start = (SVector::from([-1.2]), vec![SVector::from([1.0]); 3]);
            let minimum = minimise(&mut problem, start.0, start.1, TERMINATION).unwrap();
            assert!(minimum.converged);
            assert!(
                (minimum.shared[0] - 1.0).abs() < 1e-6,
                "{}",
                minimum.shared[0]
            );
            for y in &minimum.own {
                assert!((y[0] - 1.0).abs() < 1e-5, "{}", y[0]);
            }
        }
    }

    #[test]
    fn a_search_cut_short_has_not_converged() {
        let mut problem = RosenbrockValley { narrowness: 1e3 };
        let start = (SVector::from([-1.2]), vec![SVector::from([1.0]); 3]);
        let termination = Termination {
            iterations: 3,
            ..TERMINATION
        };
        let minimum = minimise(&mut problem, start.0, start.1, termination).unwrap();
        assert!(!minimum.converged);
    }

    /// Slope toward 0 that ends at a wall, beyond which the model is undefined.
    struct Walled {
        wall: f64,
    }

    impl ArrowProblem<1, 1> for Walled {
        fn rows(
            &mut self,
            shared: &SVector<f64, 1>,
            own: &[SVector<f64, 1>],
        ) -> Option<Vec<BlockRows<1, 1>>> {
            let slopes = [0.0, 1.0, 0.0, 7.0, 0.0, 0.0];
            let residuals = self.residuals(shared, own)?;
            let block_rows = |block: DVector<f64>| {
                let rows = [block.as_slice(), &slopes[..]].concat();
                direct_rows(DMatrix::from_column_slice(3, 3, &rows))
            };
            Some(residuals.into_iter().map(block_rows).collect())
        }

        fn residuals(
            &mut self,
            shared: &SVector<f64, 1>,
            own: &[SVector<f64, 1>],
        ) -> Option<Vec<DVector<f64>>> {
            let residuals_at = |y: &SVector<f64, 1>| vec![7.0 * shared[0], y[0], 3.0].into();
            (shared[0] >= self.wall).then(|| own.iter().map(residuals_at).collect())
        }

        fn own_prior(&self, _: usize) -> Prior<1> {
            FLAT
        }

        fn shared_prior(&self) -> Prior<1> {
            FLAT
        }
    }

    #[test]
    fn a_search_that_ends_at_the_edge_of_the_model_has_found_no_minimum() {
        for (wall, has_minimum) in [(-1.0, true), (0.75, false), (0.5, false)] {
            for tolerance in [1e-4, 1e-7, 1e-12] {
                let termination = Termination {
                    tolerance,
                    iterations: 500,
                };
                let start = (SVector::from([2.0]), vec![SVector::from([1.0])]);
                let minimum =
                    minimise(&mut Walled { wall }, start.0, start.1, termination).unwrap();
                assert_eq!(
                    minimum.converged, has_minimum,
                    "{wall}, {tolerance}: {minimum:?}"
                );
            }
        }
    }

    /// From the floor of the valley a straight step climbs its wall.
    #[test]
    fn a_step_that_bends_stays_on_the_floor() {
        let mut problem = RosenbrockValley { narrowness: 1e3 };
        let point = ParameterPoint {
            shared: SVector::from([0.7]),
            own: vec![SVector::from([0.49]); 2],
        };
        let valley = Valley::new(&mut problem, &point).unwrap();
        let step = valley.arrow.step(0.0, &valley.arrow.gradient()).unwrap();
        let bend = valley.bend(&mut problem, 0.0, &point, &step).unwrap();
        let height = |place: &ParameterPoint<1, 1>| place.own[0][0] - place.shared[0].powi(2);
        let end = point.advance(1.0, &step);
        assert!(height(&end).abs() > 1e-3);
        assert!(height(&end.advance(1.0, &bend)).abs() < 0.05 * height(&end).abs());
    }

    #[test]
    fn a_prior_counts_by_its_precision() {
        let prior = Prior {
            mean: SVector::from([1.0, 2.0]),
            precision: SVector::from([4.0, 0.0]),
        };
        let (squares, gradient) = prior.evaluate(&SVector::from([1.5, 7.0]));
        assert_eq!((squares, gradient), (1.0, SVector::from([2.0, 0.0])));
    }
}
