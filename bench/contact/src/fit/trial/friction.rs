//! The measured friction against the modelled ratio: μ0, the floor that friction does not fall below, and the delay of the
//! lateral force.
//!
//! The lateral force μ f_n is read through a first-order lag, that of its sensor. φ and the lag are a trial's, μ0 is an
//! instance's; all three come from the measured friction, after the impedance has been fitted and without a say in it. Given φ
//! and the lag, μ0 of an instance is linear, and is left out of the search (Golub & Pereyra 1973, with Kaufman's slopes).

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, Matrix2, OMatrix, U2, Vector2};
use num_complex::Complex64;

use super::super::lag::Lag;
use super::super::least_squares::correlation;
use crate::parameters::MS;
use crate::uncertain::Uncertain;

/// Samples of one instance that a trial's friction is fitted to.
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

/// Standard deviations of φ and of the lag, ms, beforehand, about 0: a finger that hardly lifts shows neither.
const PRIOR_STD: [f64; 2] = [0.3, 5.0];
const START: [f64; 2] = [0.05, 0.5];
const FLOOR: usize = 0;
const LAG_MS: usize = 1;
/// Standard deviation of the measured friction that the first search weighs priors with.
const FIRST_STD: f64 = 1e-2;

/// Fits φ, the lag and every instance's μ0 to the measured friction; `None` without a minimum.
pub(super) fn fit(instances: &[RatioSamples<'_>], interval_s: f64) -> Option<TrialFriction> {
    let n: usize = instances.iter().map(|of| of.mu.len()).sum();
    let freedom = n.saturating_sub(instances.len() + START.len()).max(1) as f64;
    let mut problem = FrictionProblem {
        instances,
        interval_s,
        std: FIRST_STD,
        parameters: Vector2::from(START),
    };
    problem = LevenbergMarquardt::new().minimize(problem).0;
    // A prior weighs against the data as much as their scatter says.
    let squares: f64 = problem.each().iter().map(InstanceFriction::squares).sum();
    problem.std = (squares / freedom).sqrt().max(f64::MIN_POSITIVE.sqrt());
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    if !report.termination.was_successful() {
        return None;
    }
    let each = problem.each();
    let residuals: Vec<Complex64> = each
        .iter()
        .flat_map(|of| of.residuals.iter().map(|&r| r.into()))
        .collect();
    let squares: f64 = residuals.iter().map(Complex64::norm_sqr).sum();
    let variance = squares / freedom * correlation(&residuals);
    let jacobian = problem.jacobian()?;
    let covariance = jacobian.tr_mul(&jacobian).try_inverse()? * variance;
    let at = |i: usize, j: usize| covariance[(i, j)];
    let at_rest = each.iter().map(|of| {
        // μ0 gives way to φ and the lag, and scatters by itself.
        let follows = Vector2::from(of.mu0_slopes);
        let across = Matrix2::from_fn(at) * follows;
        let own = variance / of.power + follows.dot(&across);
        let scatter = Matrix2::new(own, across[FLOOR], across[FLOOR], at(FLOOR, FLOOR));
        (of.mu0, scatter)
    });
    Some(TrialFriction {
        floor: Uncertain {
            value: problem.parameters[FLOOR],
            std: at(FLOOR, FLOOR).sqrt(),
        },
        lag_s: Uncertain {
            value: problem.parameters[LAG_MS] * MS,
            std: at(LAG_MS, LAG_MS).sqrt() * MS,
        },
        at_rest: at_rest.collect(),
    })
}

struct FrictionProblem<'a> {
    instances: &'a [RatioSamples<'a>],
    interval_s: f64,
    /// Standard deviation of the measured friction that the priors are weighed with.
    std: f64,
    /// φ and the lag in ms.
    parameters: Vector2<f64>,
}

/// An instance with the μ0 that fits it best.
struct InstanceFriction {
    mu0: f64,
    /// Σ of the squares of the friction for a μ0 of 1.
    power: f64,
    /// ∂μ0/∂φ and ∂μ0/∂lag.
    mu0_slopes: [f64; 2],
    residuals: Vec<f64>,
    /// Slopes of the residuals by φ and by the lag, where μ0 follows.
    slopes: [Vec<f64>; 2],
}

impl InstanceFriction {
    fn squares(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }
}

impl FrictionProblem<'_> {
    fn each(&self) -> Vec<InstanceFriction> {
        self.instances.iter().map(|of| self.instance(of)).collect()
    }

    fn instance(&self, of: &RatioSamples<'_>) -> InstanceFriction {
        let floor = self.parameters[FLOOR];
        let lag = Lag::new(self.parameters[LAG_MS] * MS, self.interval_s);
        let n = of.normal_n.len();
        let lateral = |part: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let samples = of.ratio.iter().zip(of.normal_n);
            samples.map(|(&ratio, n)| part(ratio) * n).collect()
        };
        let whole = lateral(&|ratio| floor + (1.0 - floor) * ratio);
        let lifted = lateral(&|ratio| 1.0 - ratio);
        let (mut read, mut by_floor, mut by_lag) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        lag.apply(&whole, &mut read);
        lag.apply(&lifted, &mut by_floor);
        lag.slope(&whole, &read, &mut by_lag);
        let over_force = |of_lateral: &[f64], unit: f64| -> Vec<f64> {
            let inside = of_lateral.iter().zip(of.normal_n).skip(of.lead);
            inside.map(|(lateral, n)| lateral * unit / n).collect()
        };
        let unit = over_force(&read, 1.0);
        let by = [
            over_force(&by_floor, 1.0),
            over_force(&by_lag, MS / self.interval_s),
        ];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let power = dot(&unit, &unit);
        let mu0 = dot(&unit, of.mu) / power;
        let mu0_slopes = [0, 1].map(|p| -mu0 * dot(&unit, &by[p]) / power);
        let slopes = by.map(|by| {
            let along = dot(&unit, &by) / power;
            by.iter()
                .zip(&unit)
                .map(|(by, unit)| mu0 * (by - along * unit))
                .collect()
        });
        InstanceFriction {
            mu0,
            power,
            mu0_slopes,
            residuals: unit.iter().zip(of.mu).map(|(u, mu)| mu0 * u - mu).collect(),
            slopes,
        }
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
            .each()
            .into_iter()
            .flat_map(|of| of.residuals)
            .collect();
        for (parameter, std) in PRIOR_STD.into_iter().enumerate() {
            residuals.push(self.parameters[parameter] * self.std / std);
        }
        Some(DVector::from_vec(residuals))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U2>> {
        let each = self.each();
        let column = |parameter: usize| -> Vec<f64> {
            let data = each
                .iter()
                .flat_map(|of| of.slopes[parameter].iter().copied());
            let prior = |at: usize| {
                if at == parameter {
                    self.std / PRIOR_STD[at]
                } else {
                    0.0
                }
            };
            data.chain((0..PRIOR_STD.len()).map(prior)).collect()
        };
        let columns = [column(FLOOR), column(LAG_MS)];
        Some(OMatrix::<f64, Dyn, U2>::from_fn(
            columns[0].len(),
            |row, column| columns[column][row],
        ))
    }
}
