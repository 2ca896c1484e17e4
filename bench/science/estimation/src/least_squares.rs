//! Least squares on the complex impedance of an instance, and the standard errors of its parameters.
//!
//! For residuals r_k = Ẑ_m(θ) − Z_m of sample k and slopes s_k = ∂r_k/∂θ, a vector over the free parameters,
//! Levenberg–Marquardt minimises Σ|r_k|² over the 2n real and imaginary parts. In complex form the real normal equations of a
//! step δ are
//!
//! ```text
//! N δ = −g,   N = Σ Re(s_k* s_kᵀ),   g = Σ Re(s_k* r_k)
//! Σ|r_k|² falls by −2 gᵀδ − δᵀN δ = gᵀN⁻¹g
//! ```
//!
//! Standard errors do not assume equal variances: with σ_k² that of one part of r_k, floor² + (scale · shape_k)²
//! ([`ResidualNoise`]), the gradient has the covariance Σ σ_k² Re(s_k* s_kᵀ), and so (Huber 1967; White 1980)
//!
//! ```text
//! Cov θ = c N⁻¹ (Σ σ_k² Re(s_k* s_kᵀ)) N⁻¹ + (B − N⁻¹E)(B − N⁻¹E)ᵀ,   E = Σ Re(s_k* (S_kᵀB))
//! ```
//!
//! c is the factor by which correlated r_k/σ_k lose information ([`correlation`]). Column j of B is the effect of one standard
//! deviation of calibration error j on all parameters, S_k the slopes by all of them: the error moves the residuals by S_kᵀB,
//! and the free parameters respond by −N⁻¹E (Schmidt 1966). A parameter held fixed has only its row of B.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, SMatrix, SVector};

use arrowhead::inverse_of_normal;
use num_complex::Complex64;

use contact::calibration_errors::{ByError, ERRORS};
use contact::residual_noise::ResidualNoise;

/// A model of the complex impedance of every sample of an instance, with N real parameters.
pub(crate) trait ImpedanceModel<const N: usize> {
    fn measurement(&self) -> &[Complex64];
    /// Returns the noise of a sample, in any unit; the model's own error is added to it. The fit weighs all samples alike, but
    /// its standard errors account for the noise.
    fn noise_shape(&self, index: usize) -> f64;
    /// Writes impedances and their derivatives; `None` outside the model's domain.
    fn evaluate(
        &mut self,
        parameters: &[f64; N],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; N]],
    ) -> Option<()>;
}

/// Residual per sample for a trial step outside the model's domain, N·s/m. It is far above any impedance, so the step is
/// rejected.
const DOMAIN_PENALTY: f64 = 1e6;
const TOLERANCE: f64 = 1e-12;
const PATIENCE: usize = 60;
/// Relative decrease of the squares below which a Gauss–Newton step confirms a minimum, and length of a step, in the
/// parameters' units, that is attributed to rounding.
const MAX_RELATIVE_FALL: f64 = 1e-4;
const MAX_ROUNDING_STEP: f64 = 1e-6;

pub(crate) struct Minimum<const N: usize> {
    pub(crate) parameters: [f64; N],
    pub(crate) z_m: Vec<Complex64>,
    /// Σ|Ẑ_m − Z_m|².
    pub(crate) squares: f64,
    /// Reason why the result is not a minimum; `None` for a minimum.
    pub(crate) failure: Option<String>,
    /// Parameter covariance, 0 where a parameter was held fixed and has no error; `None` if the data do not depend on some
    /// combination of the free parameters.
    pub(crate) covariance: Option<SMatrix<f64, N, N>>,
    /// Noise of one component of the residual.
    pub(crate) noise: ResidualNoise,
}

impl<const N: usize> Minimum<N> {
    /// Returns the standard error of a parameter; infinite if the data do not determine it.
    pub(crate) fn std(&self, parameter: usize) -> f64 {
        self.covariance.map_or(f64::INFINITY, |covariance| {
            covariance[(parameter, parameter)].sqrt()
        })
    }
}

struct ImpedanceProblem<'a, M, const N: usize> {
    model: &'a mut M,
    parameters: [f64; N],
    /// Indices of the fitted parameters; the others keep their values.
    free: &'a [usize],
    z_m: Vec<Complex64>,
    slopes: Vec<[Complex64; N]>,
    is_in_domain: bool,
}

impl<M: ImpedanceModel<N>, const N: usize> ImpedanceProblem<'_, M, N> {
    fn evaluate(&mut self) {
        self.is_in_domain = self
            .model
            .evaluate(&self.parameters, &mut self.z_m, &mut self.slopes)
            .is_some()
            && self.z_m.iter().all(|z| z.is_finite());
    }

    fn residual(&self, index: usize) -> Complex64 {
        self.z_m[index] - self.model.measurement()[index]
    }
}

impl<M: ImpedanceModel<N>, const N: usize> LeastSquaresProblem<f64, Dyn, Dyn>
    for ImpedanceProblem<'_, M, N>
{
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        for (&parameter, &value) in self.free.iter().zip(x.iter()) {
            self.parameters[parameter] = value;
        }
        self.evaluate();
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_fn(self.free.len(), |row, _| self.parameters[self.free[row]])
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let n = self.z_m.len();
        if !self.is_in_domain {
            return Some(DVector::from_element(2 * n, DOMAIN_PENALTY));
        }
        Some(DVector::from_fn(2 * n, |row, _| {
            if row < n {
                self.residual(row).re
            } else {
                self.residual(row - n).im
            }
        }))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let n = self.z_m.len();
        Some(DMatrix::from_fn(2 * n, self.free.len(), |row, column| {
            let slope = self.slopes[row % n][self.free[column]];
            if row < n { slope.re } else { slope.im }
        }))
    }
}

/// Returns the start with the smallest sum of squares; `None` if all starts lie outside the model's domain.
pub(crate) fn best_start<M: ImpedanceModel<N>, const N: usize>(
    model: &mut M,
    starts: impl IntoIterator<Item = [f64; N]>,
) -> Option<[f64; N]> {
    let n = model.measurement().len();
    let mut z_m = vec![Complex64::ZERO; n];
    let mut slopes = vec![[Complex64::ZERO; N]; n];
    let mut best = None;
    let mut min_squares = f64::INFINITY;
    for start in starts {
        if model.evaluate(&start, &mut z_m, &mut slopes).is_none() {
            continue;
        }
        let squares: f64 = z_m
            .iter()
            .zip(model.measurement())
            .map(|(a, b)| (a - b).norm_sqr())
            .sum();
        if squares < min_squares {
            (best, min_squares) = (Some(start), squares);
        }
    }
    best
}

/// Returns the model's impedance; `None` outside the model's domain.
pub(crate) fn model_impedances<M: ImpedanceModel<N>, const N: usize>(
    model: &mut M,
    parameters: &[f64; N],
) -> Option<Vec<Complex64>> {
    let n = model.measurement().len();
    let mut z_m = vec![Complex64::ZERO; n];
    model.evaluate(parameters, &mut z_m, &mut vec![[Complex64::ZERO; N]; n])?;
    Some(z_m)
}

/// Minimises over the `free` parameters by Levenberg–Marquardt from one start; the other parameters stay at its values. The
/// covariance includes the effect of the errors in `by_error` on all parameters, with the response of the free ones.
pub(crate) fn minimise<M: ImpedanceModel<N>, const N: usize>(
    model: &mut M,
    start: [f64; N],
    free: &[usize],
    by_error: &ByError<N>,
) -> Minimum<N> {
    let n = model.measurement().len();
    let zero = Complex64::ZERO;
    let mut problem = ImpedanceProblem {
        model,
        parameters: start,
        free,
        z_m: vec![zero; n],
        slopes: vec![[zero; N]; n],
        is_in_domain: false,
    };
    problem.evaluate();
    let (problem, report) = LevenbergMarquardt::new()
        .with_ftol(TOLERANCE)
        .with_xtol(TOLERANCE)
        .with_gtol(TOLERANCE)
        .with_patience(PATIENCE)
        .minimize(problem);
    let failure = match report.termination {
        _ if !problem.is_in_domain => Some("left the range in which the model holds".to_owned()),
        TerminationReason::NoImprovementPossible(_) => None,
        reason if reason.was_successful() => None,
        reason => Some(format!("{reason:?}")),
    };
    summarise(problem, failure, by_error)
}

fn summarise<M: ImpedanceModel<N>, const N: usize>(
    problem: ImpedanceProblem<'_, M, N>,
    failure: Option<String>,
    by_error: &ByError<N>,
) -> Minimum<N> {
    let residuals: Vec<Complex64> = (0..problem.z_m.len())
        .map(|index| problem.residual(index))
        .collect();
    let squares = residuals.iter().map(Complex64::norm_sqr).sum::<f64>();
    let shapes: Vec<f64> = (0..residuals.len())
        .map(|index| problem.model.noise_shape(index))
        .collect();
    let noise = ResidualNoise::from_residuals(&residuals, &shapes, problem.free.len());
    let deviations: Vec<f64> = shapes.iter().map(|&shape| noise.std(shape)).collect();
    let white_residuals: Vec<Complex64> = residuals
        .iter()
        .zip(&deviations)
        .map(|(residual, deviation)| residual / deviation)
        .collect();
    let equations = NormalEquations::new(&problem, &residuals, &deviations, by_error);
    let inverse = inverse_of_normal(&equations.normal);
    let is_unfinished = inverse
        .as_ref()
        .is_some_and(|inverse| equations.is_unfinished(inverse, squares));
    let edge_failure = || "stopped at the edge of the range in which the model holds".to_owned();
    let failure = failure.or_else(|| is_unfinished.then(edge_failure));
    let covariance = inverse.map(|inverse| {
        equations.covariance(
            &inverse,
            correlation(&white_residuals),
            problem.free,
            by_error,
        )
    });
    Minimum {
        parameters: problem.parameters,
        z_m: problem.z_m,
        squares,
        failure,
        covariance,
        noise,
    }
}

/// Sums over all samples, for the free parameters.
struct NormalEquations {
    /// N = Σ Re(s_k* s_kᵀ).
    normal: DMatrix<f64>,
    /// Σ σ_k² Re(s_k* s_kᵀ).
    scatter: DMatrix<f64>,
    /// g = Σ Re(s_k* r_k).
    gradient: DVector<f64>,
    /// E = Σ Re(s_k* (S_kᵀB)).
    error_gradient: DMatrix<f64>,
}

impl NormalEquations {
    fn new<M: ImpedanceModel<N>, const N: usize>(
        problem: &ImpedanceProblem<'_, M, N>,
        residuals: &[Complex64],
        deviations: &[f64],
        by_error: &ByError<N>,
    ) -> Self {
        let size = problem.free.len();
        let mut sums = Self {
            normal: DMatrix::zeros(size, size),
            scatter: DMatrix::zeros(size, size),
            gradient: DVector::zeros(size),
            error_gradient: DMatrix::zeros(size, ERRORS),
        };
        let by_error = by_error.map(Complex64::from);
        let samples = problem.slopes.iter().zip(deviations).zip(residuals);
        for ((slope, deviation), residual) in samples {
            let free = |row: usize| slope[problem.free[row]];
            sums.gradient += DVector::from_fn(size, |row, _| (free(row).conj() * residual).re);
            let errors = SVector::from(*slope).tr_mul(&by_error);
            sums.error_gradient += DMatrix::from_fn(size, ERRORS, |row, error| {
                (free(row).conj() * errors[error]).re
            });
            // Re(a* b) = Re a Re b + Im a Im b: both parts of the residual in one product.
            let product = DMatrix::from_fn(size, size, |row, column| {
                (free(row).conj() * free(column)).re
            });
            sums.scatter += &product * deviation.powi(2);
            sums.normal += product;
        }
        sums
    }

    /// Returns whether a Gauss–Newton step −N⁻¹g would still lower the squares. Rejected steps out of the domain shorten the
    /// steps that follow, and a short step can be mistaken for convergence.
    fn is_unfinished(&self, inverse: &DMatrix<f64>, squares: f64) -> bool {
        // The fall is gᵀN⁻¹g.
        let step = inverse * &self.gradient;
        step.amax() > MAX_ROUNDING_STEP && step.dot(&self.gradient) > MAX_RELATIVE_FALL * squares
    }

    /// Returns Cov θ for the factor c by which correlation loses information.
    fn covariance<const N: usize>(
        &self,
        inverse: &DMatrix<f64>,
        information_loss: f64,
        free: &[usize],
        by_error: &ByError<N>,
    ) -> SMatrix<f64, N, N> {
        let free_covariance = inverse * &self.scatter * inverse * information_loss;
        let mut by_error = *by_error;
        for (response, &parameter) in (inverse * &self.error_gradient).row_iter().zip(free) {
            let mut row = by_error.row_mut(parameter);
            row -= response;
        }
        let mut covariance = by_error * by_error.transpose();
        for (row, &i) in free.iter().enumerate() {
            for (column, &j) in free.iter().enumerate() {
                covariance[(i, j)] += free_covariance[(row, column)];
            }
        }
        covariance
    }
}

/// Returns 1 + 2 Σ ρ_k over the lags before the autocorrelation first vanishes. Neighbouring residuals share the demodulator's
/// window and the model's error, so n samples carry less information than n independent values.
///
/// ρ_k = Σ_j Re(r_j* r_(j+k))/Σ_j |r_j|². For slopes that change little while the correlation lasts,
/// Var Σ s_j r_j = Σ_jk s_j s_k ρ_|j−k| σ² ≈ (1 + 2 Σ ρ_k) σ² Σ s_j² (Bayley & Hammersley 1946).
pub(crate) fn correlation(residuals: &[Complex64]) -> f64 {
    let autocovariance = |lag: usize| {
        residuals
            .iter()
            .zip(&residuals[lag..])
            .map(|(a, b)| (a.conj() * b).re)
            .sum::<f64>()
    };
    let power = autocovariance(0);
    // Without residuals the autocorrelation is undefined.
    if power.is_nan() || power <= 0.0 {
        return 1.0;
    }
    let sum: f64 = (1..residuals.len())
        .map(|lag| autocovariance(lag) / power)
        .take_while(|rho| *rho > 0.0)
        .sum();
    1.0 + 2.0 * sum
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Model with impedances equal to a parameter, undefined below a wall.
    struct Walled {
        measurement: Vec<Complex64>,
        wall: f64,
    }

    impl ImpedanceModel<1> for Walled {
        fn measurement(&self) -> &[Complex64] {
            &self.measurement
        }

        fn noise_shape(&self, _: usize) -> f64 {
            1.0
        }

        fn evaluate(
            &mut self,
            parameters: &[f64; 1],
            z_m: &mut [Complex64],
            slopes: &mut [[Complex64; 1]],
        ) -> Option<()> {
            z_m.fill(parameters[0].into());
            slopes.fill([Complex64::ONE]);
            (parameters[0] >= self.wall).then_some(())
        }
    }

    #[test]
    fn a_search_that_ends_at_the_edge_of_the_model_has_found_no_minimum() {
        let measurement: Vec<Complex64> = (0..40).map(|n| f64::from(n % 5).into()).collect();
        for (wall, is_minimum) in [(f64::NEG_INFINITY, true), (1.9, true), (2.5, false)] {
            let mut model = Walled {
                measurement: measurement.clone(),
                wall,
            };
            let minimum = minimise(&mut model, [9.0], &[0], &ByError::zeros());
            assert_eq!(
                minimum.failure.is_none(),
                is_minimum,
                "{wall}: {:?}",
                minimum.parameters
            );
        }
        // Without residuals, the remaining error is rounding.
        let mut exact = Walled {
            measurement: vec![Complex64::new(0.3, 0.0); 40],
            wall: 0.0,
        };
        let minimum = minimise(&mut exact, [9.0], &[0], &ByError::zeros());
        assert_eq!(minimum.failure, None);
    }

    /// Compares every slope with central differences of the impedance.
    pub(crate) fn assert_slopes_are_derivatives<const N: usize>(
        model: &mut impl ImpedanceModel<N>,
        parameters: [f64; N],
    ) {
        let n = model.measurement().len();
        let mut evaluate = |parameters: &[f64; N]| {
            let (mut z_m, mut slopes) = (vec![Complex64::ZERO; n], vec![[Complex64::ZERO; N]; n]);
            assert!(model.evaluate(parameters, &mut z_m, &mut slopes).is_some());
            (z_m, slopes)
        };
        let (_, slopes) = evaluate(&parameters);
        for parameter in 0..N {
            let h = 1e-5;
            let (mut above, mut below) = (parameters, parameters);
            above[parameter] += h;
            below[parameter] -= h;
            let (above, below) = (evaluate(&above).0, evaluate(&below).0);
            for i in 0..n {
                let difference = (above[i] - below[i]) / (2.0 * h);
                let error = (difference - slopes[i][parameter]).norm();
                assert!(
                    error < 1e-7 * (1.0 + difference.norm()),
                    "parameter {parameter}, sample {i}: {error}"
                );
            }
        }
    }
}
