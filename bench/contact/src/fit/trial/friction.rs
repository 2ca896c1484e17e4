//! The measured friction against the modelled ratio: μ0, the floor that friction does not fall below, and the delay of the
//! lateral force.
//!
//! The lateral force μ f_n is read through a first-order lag, that of its sensor. φ and the lag are a trial's, μ0 is an
//! instance's; all three come from the measured friction, after the impedance has been fitted and without a say in it.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, Matrix2};
use num_complex::Complex64;

use super::super::lag::Lag;
use super::super::least_squares::{correlation, invert_scaled};
use crate::live_estimator::Uncertain;
use crate::parameters::MS;

/// What a trial's friction is fitted to, one for each instance.
pub(super) struct RatioSamples<'a> {
    /// Modelled friction ratio, with the lead-in.
    pub(super) ratio: Vec<f64>,
    /// Normal force, with the lead-in, N.
    pub(super) normal_n: &'a [f64],
    /// Number of samples of lead-in.
    pub(super) lead: usize,
    /// Measured friction, of the instance alone.
    pub(super) mu: &'a [f64],
}

/// Friction of a trial.
pub(super) struct TrialFriction {
    /// φ.
    pub(super) floor: Uncertain,
    /// Lag of the lateral force, s.
    pub(super) lag_s: Uncertain,
    /// μ0 of each instance, and the covariance of it with φ.
    pub(super) at_rest: Vec<(f64, Matrix2<f64>)>,
}

/// Standard deviations of φ and of the lag beforehand, about 0: they hold what a finger that hardly lifts does not show.
const FLOOR_STD: f64 = 0.3;
const LAG_STD_MS: f64 = 5.0;
const START: [f64; 2] = [0.05, 0.5];
const FLOOR: usize = 0;
const LAG_MS: usize = 1;
const FIRST_MU0: usize = 2;

/// Fits φ, the lag and every instance's μ0 to the measured friction; `None` without a minimum.
pub(super) fn fit(instances: &[RatioSamples<'_>], interval_s: f64) -> Option<TrialFriction> {
    let n: usize = instances.iter().map(|of| of.mu.len()).sum();
    let mut problem = FrictionProblem {
        instances,
        interval_s,
        prior_weight: 1e-2,
        parameters: DVector::zeros(FIRST_MU0 + instances.len()),
    };
    problem.parameters[FLOOR] = START[FLOOR];
    problem.parameters[LAG_MS] = START[LAG_MS];
    for (index, of) in instances.iter().enumerate() {
        let greatest = of.mu.iter().copied().fold(0.0, f64::max);
        problem.parameters[FIRST_MU0 + index] = greatest;
    }
    let (mut problem, report) = LevenbergMarquardt::new().minimize(problem);
    // A prior weighs against the data as much as their scatter says.
    let freedom = n.saturating_sub(problem.parameters.len()).max(1) as f64;
    problem.prior_weight = (2.0 * report.objective_function / freedom).sqrt();
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    if !report.termination.was_successful() {
        return None;
    }
    let residuals = problem.residuals()?;
    let measured: Vec<Complex64> = residuals.iter().take(n).map(|&r| r.into()).collect();
    let variance = measured.iter().map(Complex64::norm_sqr).sum::<f64>() / freedom;
    let jacobian = problem.jacobian()?;
    let covariance =
        invert_scaled(&jacobian.tr_mul(&jacobian))? * (variance * correlation(&measured));
    let at = |i: usize, j: usize| covariance[(i, j)];
    let at_rest = (FIRST_MU0..problem.parameters.len())
        .map(|i| {
            let scatter = Matrix2::new(at(i, i), at(i, FLOOR), at(FLOOR, i), at(FLOOR, FLOOR));
            (problem.parameters[i], scatter)
        })
        .collect();
    Some(TrialFriction {
        floor: Uncertain {
            value: problem.parameters[FLOOR],
            std: at(FLOOR, FLOOR).sqrt(),
        },
        lag_s: Uncertain {
            value: problem.parameters[LAG_MS] * MS,
            std: at(LAG_MS, LAG_MS).sqrt() * MS,
        },
        at_rest,
    })
}

struct FrictionProblem<'a> {
    instances: &'a [RatioSamples<'a>],
    interval_s: f64,
    /// Standard deviation of the measured friction that the priors are weighed with.
    prior_weight: f64,
    /// φ, the lag in ms, μ0 of each instance.
    parameters: DVector<f64>,
}

/// An instance's friction for a μ0 of 1, and its slopes by φ and by the lag in ms.
struct UnitFriction {
    value: Vec<f64>,
    by_floor: Vec<f64>,
    by_lag_ms: Vec<f64>,
}

impl FrictionProblem<'_> {
    fn unit(&self, of: &RatioSamples<'_>) -> UnitFriction {
        let (floor, lag) = (
            self.parameters[FLOOR],
            Lag::new(self.parameters[LAG_MS] * MS, self.interval_s),
        );
        let n = of.normal_n.len();
        let lateral: Vec<f64> = of
            .ratio
            .iter()
            .zip(of.normal_n)
            .map(|(ratio, normal_n)| (floor + (1.0 - floor) * ratio) * normal_n)
            .collect();
        let lifted: Vec<f64> = of
            .ratio
            .iter()
            .zip(of.normal_n)
            .map(|(ratio, normal_n)| (1.0 - ratio) * normal_n)
            .collect();
        let (mut value, mut by_floor, mut by_lag) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        lag.apply(&lateral, &mut value);
        lag.apply(&lifted, &mut by_floor);
        lag.slope(&lateral, &value, &mut by_lag);
        let over_force = |of_lateral: &[f64], unit: f64| {
            let inside = of_lateral.iter().zip(of.normal_n).skip(of.lead);
            inside.map(|(lateral, n)| lateral * unit / n).collect()
        };
        UnitFriction {
            value: over_force(&value, 1.0),
            by_floor: over_force(&by_floor, 1.0),
            by_lag_ms: over_force(&by_lag, MS / self.interval_s),
        }
    }

    fn priors(&self) -> [f64; 2] {
        [
            self.prior_weight / FLOOR_STD,
            self.prior_weight / LAG_STD_MS,
        ]
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for FrictionProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.parameters.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut residuals = Vec::new();
        for (index, of) in self.instances.iter().enumerate() {
            let mu0 = self.parameters[FIRST_MU0 + index];
            let unit = self.unit(of);
            residuals.extend(
                unit.value
                    .iter()
                    .zip(of.mu)
                    .map(|(unit, mu)| mu0 * unit - mu),
            );
        }
        for (parameter, weight) in self.priors().into_iter().enumerate() {
            residuals.push(self.parameters[parameter] * weight);
        }
        Some(DVector::from_vec(residuals))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let n: usize = self.instances.iter().map(|of| of.mu.len()).sum();
        let priors = self.priors();
        let mut jacobian = DMatrix::zeros(n + priors.len(), self.parameters.len());
        let mut row = 0;
        for (index, of) in self.instances.iter().enumerate() {
            let mu0 = self.parameters[FIRST_MU0 + index];
            let unit = self.unit(of);
            for i in 0..of.mu.len() {
                jacobian[(row, FLOOR)] = mu0 * unit.by_floor[i];
                jacobian[(row, LAG_MS)] = mu0 * unit.by_lag_ms[i];
                jacobian[(row, FIRST_MU0 + index)] = unit.value[i];
                row += 1;
            }
        }
        for (parameter, weight) in priors.into_iter().enumerate() {
            jacobian[(n + parameter, parameter)] = weight;
        }
        Some(jacobian)
    }
}
