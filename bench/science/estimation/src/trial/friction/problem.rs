//! Search for φ and the lag.
//!
//! The sum Σ r² + s² ((φ/0.3)² + (λ/5 ms)²), with the residuals r of all instances (`instance.rs`) and s² their variance, is
//! minimised over φ and λ: s² times −2 ln of the posterior for normal residuals and normal priors about 0.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, OMatrix, U2, Vector2};

use super::instance::{Instance, InstanceFriction};
use super::{FRICTION_PARAMETERS, FrictionParameter};

/// Prior standard deviations of φ and of the lag, ms, about 0: a finger that hardly lifts determines neither.
const PRIOR_STD: [f64; FRICTION_PARAMETERS] = [0.3, 5.0];
const START: [f64; FRICTION_PARAMETERS] = [0.05, 0.5];
/// Standard deviation of the measured friction by which the first search weighs the priors.
const FIRST_STD: f64 = 1e-2;

pub(super) struct FrictionProblem<'a> {
    instances: &'a [Instance<'a>],
    /// Standard deviation of the measured friction by which the priors are weighed.
    std: f64,
    /// φ and the lag in ms.
    pub(super) parameters: Vector2<f64>,
}

impl<'a> FrictionProblem<'a> {
    /// Returns the problem at its minimum, with the priors weighed against the data by the scatter of the residuals; `None` if
    /// the search does not converge.
    pub(super) fn minimise(instances: &'a [Instance<'a>]) -> Option<Self> {
        let start = Self {
            instances,
            std: FIRST_STD,
            parameters: Vector2::from(START),
        };
        let (mut problem, _) = LevenbergMarquardt::new().minimize(start);
        let fits = problem.fits();
        let squares: f64 = fits.iter().map(InstanceFriction::squares).sum();
        let std = (squares / problem.freedom()).sqrt();
        problem.std = std.max(f64::MIN_POSITIVE.sqrt());
        let (problem, report) = LevenbergMarquardt::new().minimize(problem);
        report.termination.was_successful().then_some(problem)
    }

    /// Returns every instance's best fit for the current φ and lag.
    pub(super) fn fits(&self) -> Vec<InstanceFriction<'a>> {
        let instances = self.instances.iter();
        instances
            .map(|instance| instance.fit(&self.parameters))
            .collect()
    }

    /// Returns the number of residuals minus that of the parameters, at least 1.
    pub(super) fn freedom(&self) -> f64 {
        let samples = self
            .instances
            .iter()
            .map(|instance| instance.samples.mu.len());
        let parameters = self.instances.len() + FRICTION_PARAMETERS;
        samples.sum::<usize>().saturating_sub(parameters).max(1) as f64
    }
}

impl LeastSquaresProblem<f64, Dyn, U2> for FrictionProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U2>;
    type ParameterStorage = Owned<f64, U2>;

    fn set_params(&mut self, x: &Vector2<f64>) {
        self.parameters = *x;
    }

    fn params(&self) -> Vector2<f64> {
        self.parameters
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut residuals: Vec<f64> = self
            .fits()
            .into_iter()
            .flat_map(|fit| fit.residuals)
            .collect();
        for (parameter, std) in PRIOR_STD.into_iter().enumerate() {
            residuals.push(self.parameters[parameter] * self.std / std);
        }
        Some(DVector::from_vec(residuals))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U2>> {
        let fits = self.fits();
        let column = |parameter: usize| -> Vec<f64> {
            let data = fits
                .iter()
                .flat_map(|fit| fit.slopes[parameter].iter().copied());
            let prior = |index: usize| {
                if index == parameter {
                    self.std / PRIOR_STD[index]
                } else {
                    0.0
                }
            };
            data.chain((0..PRIOR_STD.len()).map(prior)).collect()
        };
        let columns = [FrictionParameter::Floor, FrictionParameter::LagMs]
            .map(|parameter| column(parameter as usize));
        Some(OMatrix::<f64, Dyn, U2>::from_fn(
            columns[0].len(),
            |row, column| columns[column][row],
        ))
    }
}
