//! Solution of the plate's model by Levenberg–Marquardt.

use levenberg_marquardt::LevenbergMarquardt;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use statistics::wrap_rad;

use super::coarse::CoarseResonance;
use super::linear::LinearFit;
use super::plate_fit_error::PlateFitError;
use super::problem::{ModelValue, PARAMETERS, PlateProblem, Terms, mode};
use super::response::Response;

const TOLERANCE: f64 = 1e-13;

/// Starting point of a solution.
#[derive(Clone, Copy)]
pub(super) struct StartingPoint {
    pub(super) reference_hz: f64,
    pub(super) parameters: [f64; PARAMETERS],
}

impl StartingPoint {
    /// Returns the point with this resonance; its linear parameters are those that fit the responses best.
    pub(super) fn new(responses: &[Response], coarse: CoarseResonance) -> Option<Self> {
        let CoarseResonance {
            resonance_hz,
            quality,
        } = coarse;
        let column = |value: &dyn Fn(f64) -> Complex64| {
            let ratios = responses.iter().map(|r| r.frequency_hz / resonance_hz);
            ratios.map(value).collect::<Vec<_>>()
        };
        let columns = vec![
            column(&|r| mode(r, quality)),
            column(&|_| Complex64::ONE),
            column(&|r| Complex64::from(r - 1.0)),
        ];
        let data: Vec<Complex64> = responses.iter().map(|r| r.ratio).collect();
        let linear = LinearFit::new(columns, &data)?;
        let [response, offset, slope] = linear.coefficients.try_into().ok()?;
        let mut parameters = [0.0; PARAMETERS];
        parameters[..8].copy_from_slice(&[
            0.0,
            quality.ln(),
            response.norm().ln(),
            wrap_rad(-response.arg()),
            offset.re,
            offset.im,
            slope.re,
            slope.im,
        ]);
        let is_finite = parameters.iter().all(|value| value.is_finite());
        is_finite.then_some(Self {
            reference_hz: resonance_hz,
            parameters,
        })
    }
}

/// Solution of the model.
pub(super) struct PlateSolution {
    pub(super) reference_hz: f64,
    pub(super) parameters: [f64; PARAMETERS],
    /// Variance of each parameter for residuals with a variance of 1.
    pub(super) unit_variance: [f64; PARAMETERS],
    /// Σ|residual|².
    pub(super) squares: f64,
    pub(super) terms: Terms,
    pub(super) values: Vec<ModelValue>,
}

impl PlateSolution {
    /// Solves the model with `terms` from a starting point.
    pub(super) fn new(
        responses: &[Response],
        start: StartingPoint,
        terms: Terms,
    ) -> Result<Self, PlateFitError> {
        let mut parameters = start.parameters;
        for parameter in parameters.iter_mut().skip(terms.count()) {
            *parameter = 0.0;
        }
        let problem = PlateProblem {
            responses,
            reference_hz: start.reference_hz,
            parameters,
            terms,
        };
        let (problem, report) = LevenbergMarquardt::new()
            .with_ftol(TOLERANCE)
            .with_xtol(TOLERANCE)
            .with_gtol(TOLERANCE)
            .with_patience(200)
            .minimize(problem);
        // Covariance s² (JᵀJ)⁻¹ with s² = Σ|residual|²/(2n − p); the objective is half the sum of squares. JᵀJ is scaled to a
        // unit diagonal before its inversion, because the parameters differ by orders of magnitude.
        let free = terms.count();
        let jacobian = problem.jacobian_matrix();
        let normal = jacobian.transpose() * &jacobian;
        let scale = DVector::from_fn(free, |i, _| normal[(i, i)].sqrt().recip());
        let scaled = DMatrix::from_fn(free, free, |i, j| normal[(i, j)] * scale[i] * scale[j]);
        let inverse = scaled.cholesky().ok_or(PlateFitError::NoFit)?.inverse();
        let mut unit_variance = [0.0; PARAMETERS];
        for (i, v) in unit_variance.iter_mut().enumerate().take(free) {
            *v = inverse[(i, i)] * scale[i].powi(2);
        }
        let mut numbers = problem.parameters.iter().chain(&unit_variance);
        let is_sane = numbers.all(|v| v.is_finite())
            && problem.parameters[0].abs() < 0.1
            && (0.0..15.0).contains(&problem.parameters[1]);
        if !is_sane {
            return Err(PlateFitError::NoFit);
        }
        Ok(Self {
            reference_hz: start.reference_hz,
            parameters: problem.parameters,
            unit_variance,
            squares: 2.0 * report.objective_function,
            terms,
            values: responses
                .iter()
                .map(|r| problem.model(r.frequency_hz))
                .collect(),
        })
    }

    /// Returns the point at which this solution lies, to start another one.
    pub(super) fn starting_point(&self) -> StartingPoint {
        StartingPoint {
            reference_hz: self.reference_hz,
            parameters: self.parameters,
        }
    }

    pub(super) fn resonance_hz(&self) -> f64 {
        self.reference_hz * (1.0 + self.parameters[0])
    }

    /// Returns the second mode at a frequency; zero if the model has none.
    pub(super) fn second_mode(&self, frequency_hz: f64) -> Complex64 {
        if self.terms != Terms::SecondMode {
            return Complex64::ZERO;
        }
        let p = &self.parameters;
        let r = frequency_hz / (self.reference_hz * (1.0 + p[8]));
        Complex64::new(p[10], p[11]) * mode(r, p[9].exp())
    }

    pub(super) fn quality(&self) -> f64 {
        self.parameters[1].exp()
    }

    /// Returns the degrees of freedom: two values a response, less the parameters.
    pub(super) fn freedom(&self) -> usize {
        (2 * self.values.len()).saturating_sub(self.terms.count())
    }

    /// Returns the variance of a real or imaginary part of a residual.
    pub(super) fn scatter(&self) -> f64 {
        self.squares / self.freedom().max(1) as f64
    }
}
