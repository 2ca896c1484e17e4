//! Fit of the measured friction to the modelled ratio: μ0, the floor below which friction does not fall, and the lag of the
//! lateral force.
//!
//! The lateral force μ f_n is read through the first-order lag of its sensor. φ and the lag are shared by a trial, μ0 belongs
//! to an instance. All three are fitted to the measured friction after the impedance and do not affect its fit. Given φ and
//! the lag, the problem is linear in the instance's μ0, which is projected out (Golub & Pereyra 1973, with Kaufman's slopes).

use first_order_lag::Lag;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, Matrix2, Matrix3, OMatrix, SMatrix, SVector, U2, Vector2};
use num_complex::Complex64;
use random_walk::{Means, spread};

use crate::friction_law::{Course, FrictionLaw};
use crate::lagged_model::OF_GAP;
use crate::least_squares::correlation;
use crate::trend::{NEIGHBOURS_S, rate_about};
use contact::parameters::{LN_FORCE, MS, PARAMETERS};
use contact::uncertain::Uncertain;

/// Samples of one instance for the fit of a trial's friction.
pub(super) struct RatioSamples<'a> {
    /// Modelled friction ratio, with the lead-in.
    pub(super) ratio: Vec<f64>,
    /// Normal force, with the lead-in, N.
    pub(super) normal_n: &'a [f64],
    /// Number of samples of lead-in.
    pub(super) lead: usize,
    /// Measured friction of the instance, without the lead-in.
    pub(super) mu: &'a [f64],
    /// ∂`ratio`/∂parameter, for the parameters in [`OF_GAP`].
    pub(super) ratio_slopes: [Vec<f64>; OF_GAP.len()],
    /// Time, with the lead-in, s.
    pub(super) time_s: &'a [f64],
    /// Time at the middle of the instance, s.
    pub(super) middle_s: f64,
}

/// Friction of a trial.
pub(super) struct TrialFriction {
    /// φ.
    pub(super) floor: Uncertain,
    /// Lag of the lateral force, s.
    pub(super) lag_s: Uncertain,
    /// Friction at rest of each instance.
    pub(super) each: Vec<AtRest>,
}

/// Number of parameters shared by a trial: φ and the lag.
pub(super) const OF_TRIAL: usize = 2;

/// μ0 of an instance, with its variances and derivatives.
pub(super) struct AtRest {
    /// μ0 at the middle of the instance.
    pub(super) mu0: f64,
    /// Change of μ0 within the instance.
    pub(super) course: Course,
    /// Variance of μ0 from the scatter of the measured friction, with φ and the lag held fixed and no random walk of μ0.
    alone: f64,
    /// Covariance of μ0 and φ from the scatter of the measured friction.
    pub(super) scatter: Matrix2<f64>,
    /// Derivatives of μ0 by φ and the lag.
    pub(super) by_trial: SVector<f64, OF_TRIAL>,
    /// Derivatives of μ0 by the instance's contact, with φ and the lag held fixed.
    pub(super) by_contact: SVector<f64, PARAMETERS>,
    /// Derivatives of φ and the lag by the instance's contact.
    pub(super) trial_by_contact: SMatrix<f64, OF_TRIAL, PARAMETERS>,
}

impl TrialFriction {
    /// Returns an instance's friction law for an exactly known contact.
    pub(super) fn held(&self, index: usize) -> FrictionLaw<PARAMETERS> {
        let of = &self.each[index];
        FrictionLaw {
            mu0: of.mu0,
            course: of.course,
            floor: self.floor.value,
            lag_s: self.lag_s.value,
            slopes: of.by_contact.into(),
            floor_slopes: [0.0; PARAMETERS],
            scatter: of.scatter,
        }
    }
}

/// Prior standard deviations of φ and of the lag, ms, about 0: a finger that hardly lifts determines neither.
const PRIOR_STD: [f64; 2] = [0.3, 5.0];
const START: [f64; 2] = [0.05, 0.5];
pub(super) const FLOOR: usize = 0;
pub(super) const LAG_MS: usize = 1;
/// Standard deviation of the measured friction by which the first search weighs the priors.
const FIRST_STD: f64 = 1e-2;

/// Ratio of the diffusivity of μ0 within an instance to that between instances. Friction depends on the finger's speed; the
/// hand's tremor of 8 to 12 Hz changes speed within 60 ms, but hardly its mean over an instance.
const FASTER_WITHIN: f64 = 2.0;

/// Number of iterations in which the trend of μ0 between instances is applied within each.
const FOLLOWED: usize = 2;

/// Fits φ, the lag and every instance's μ0 to the measured friction; `None` if the fit does not converge.
pub(super) fn fit(instances: &[RatioSamples<'_>], interval_s: f64) -> Option<TrialFriction> {
    let times_s: Vec<f64> = instances.iter().map(|of| of.middle_s).collect();
    let at = |middle_s: f64, per_s: f64| Course { per_s, middle_s };
    let mut courses: Vec<Course> = times_s.iter().map(|&of| at(of, 0.0)).collect();
    for _ in 0..FOLLOWED {
        let found = fit_on(&courses, 0.0, instances, interval_s)?;
        let mu0 = |of: usize| found.each[of].mu0;
        for (index, course) in courses.iter_mut().enumerate() {
            course.per_s = rate_about(index, &times_s, mu0) / mu0(index);
        }
    }
    let still = fit_on(&courses, 0.0, instances, interval_s)?;
    let measured = |of: &AtRest| (of.mu0, of.alone);
    let mu0: Vec<(f64, f64)> = still.each.iter().map(measured).collect();
    let per_s: Vec<f64> = courses.iter().map(|of| of.per_s).collect();
    let samples: usize = instances.iter().map(|of| of.mu.len()).sum();
    let each_s = interval_s * samples as f64 / instances.len() as f64;
    let means = Means {
        times_s: &times_s,
        each_s,
        apart_s: NEIGHBOURS_S,
        values: &mu0,
        per_s: &per_s,
    };
    let wander_per_s = FASTER_WITHIN * means.diffusivity_per_s();
    fit_on(&courses, wander_per_s, instances, interval_s)
}

fn fit_on(
    courses: &[Course],
    wander_per_s: f64,
    instances: &[RatioSamples<'_>],
    interval_s: f64,
) -> Option<TrialFriction> {
    let n: usize = instances.iter().map(|of| of.mu.len()).sum();
    let freedom = n.saturating_sub(instances.len() + START.len()).max(1) as f64;
    let mut problem = FrictionProblem {
        instances,
        courses,
        interval_s,
        std: FIRST_STD,
        parameters: Vector2::from(START),
    };
    problem = LevenbergMarquardt::new().minimize(problem).0;
    // Weigh the priors against the data by the scatter of the residuals.
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
    let inverse = jacobian.tr_mul(&jacobian).try_inverse()?;
    let wandered: Vec<Matrix3<f64>> = each
        .iter()
        .map(|of| of.wandered(&inverse) * (wander_per_s * interval_s))
        .collect();
    let of_trial = |of: &Matrix3<f64>| of.fixed_view::<2, 2>(1, 1).into_owned();
    let covariance = inverse * variance + wandered.iter().map(of_trial).sum::<Matrix2<f64>>();
    let at = |i: usize, j: usize| covariance[(i, j)];
    let of_samples = instances.iter().zip(courses).zip(&wandered);
    let each = each
        .iter()
        .zip(of_samples)
        .map(|(of, ((samples, course), wandered))| {
            // The variance of μ0 combines its own scatter with that of φ and the lag.
            let follows = Vector2::from(of.mu0_slopes);
            let with_trial = wandered.fixed_view::<2, 1>(1, 0);
            let alone = variance / of.power;
            let own = alone
                + wandered[(0, 0)]
                + 2.0 * follows.dot(&with_trial)
                + follows.dot(&(covariance * follows));
            let across = covariance * follows + with_trial;
            let (by_contact, residuals_moved) = problem.moved_by_contact(samples, course, of);
            AtRest {
                mu0: of.mu0,
                course: *course,
                alone,
                scatter: Matrix2::new(own, across[FLOOR], across[FLOOR], at(FLOOR, FLOOR)),
                by_trial: follows,
                by_contact,
                trial_by_contact: -inverse * residuals_moved,
            }
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
        each: each.collect(),
    })
}

struct FrictionProblem<'a> {
    instances: &'a [RatioSamples<'a>],
    courses: &'a [Course],
    interval_s: f64,
    /// Standard deviation of the measured friction by which the priors are weighed.
    std: f64,
    /// φ and the lag in ms.
    parameters: Vector2<f64>,
}

/// Instance with its best-fitting μ0.
struct InstanceFriction {
    mu0: f64,
    /// Σ of the squares of the friction for a μ0 of 1.
    power: f64,
    /// ∂μ0/∂φ and ∂μ0/∂lag.
    mu0_slopes: [f64; 2],
    /// Friction for a μ0 of 1.
    unit: Vec<f64>,
    residuals: Vec<f64>,
    /// Slopes of the residuals by φ and by the lag, with μ0 refitted.
    slopes: [Vec<f64>; 2],
}

impl InstanceFriction {
    fn squares(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }

    /// Returns the covariance of μ0, φ and the lag for a μ0 that walks with a diffusivity of 1 per sample; the variance of μ0
    /// excludes its dependence on the other two.
    fn wandered(&self, inverse: &Matrix2<f64>) -> Matrix3<f64> {
        let least = 1.0 / self.unit.len() as f64;
        let of_mu0 = self.unit.iter().map(|u| u * u / self.power - least);
        let of_mu0: Vec<f64> = of_mu0.map(|weight| weight * self.mu0).collect();
        let [by_floor, by_lag] = &self.slopes;
        let slopes = by_floor.iter().zip(by_lag).zip(&self.unit);
        let of_trial: Vec<Vector2<f64>> = slopes
            .map(|((floor, lag), unit)| inverse * Vector2::new(*floor, *lag) * (self.mu0 * unit))
            .collect();
        spread(&of_mu0, &of_trial)
    }
}

impl FrictionProblem<'_> {
    fn each(&self) -> Vec<InstanceFriction> {
        let each = self.instances.iter().zip(self.courses);
        each.map(|(of, course)| self.instance(of, course)).collect()
    }

    fn instance(&self, of: &RatioSamples<'_>, course: &Course) -> InstanceFriction {
        let floor = self.parameters[FLOOR];
        let lag = Lag::new(self.parameters[LAG_MS] * MS, self.interval_s);
        let n = of.normal_n.len();
        let lateral = |part: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let samples = of.ratio.iter().zip(of.normal_n).zip(of.time_s);
            samples
                .map(|((&ratio, n), &time_s)| part(ratio) * n * course.at(time_s))
                .collect()
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
            unit,
        }
    }

    /// Returns the derivatives by the contact of an instance's μ0, with φ and the lag held fixed, and of the gradient by those
    /// two.
    fn moved_by_contact(
        &self,
        of: &RatioSamples<'_>,
        course: &Course,
        fitted: &InstanceFriction,
    ) -> (SVector<f64, PARAMETERS>, SMatrix<f64, OF_TRIAL, PARAMETERS>) {
        let lag = Lag::new(self.parameters[LAG_MS] * MS, self.interval_s);
        let by_ratio = fitted.mu0 * (1.0 - self.parameters[FLOOR]);
        let mut read = vec![0.0; of.normal_n.len()];
        let (mut by_contact, mut gradient) = (SVector::zeros(), SMatrix::zeros());
        for (parameter, slopes) in OF_GAP.into_iter().zip(&of.ratio_slopes) {
            let samples = slopes.iter().zip(of.normal_n).zip(of.time_s);
            let lateral: Vec<f64> = samples
                .map(|((slope, n), &time_s)| by_ratio * slope * n * course.at(time_s))
                .collect();
            lag.apply(&lateral, &mut read);
            let mut moved: Vec<f64> = read
                .iter()
                .zip(of.normal_n)
                .skip(of.lead)
                .map(|(read, n)| read / n)
                .collect();
            if parameter == LN_FORCE {
                // The measured friction is the lateral force divided by the normal force.
                moved.iter_mut().zip(of.mu).for_each(|(by, mu)| *by += mu);
            }
            by_contact[parameter] = -dot(&fitted.unit, &moved) / fitted.power;
            for (row, slopes) in fitted.slopes.iter().enumerate() {
                gradient[(row, parameter)] = dot(slopes, &moved);
            }
        }
        (by_contact, gradient)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    const INTERVAL_S: f64 = 5e-4;
    const LEAD: usize = 40;
    const SAMPLES: usize = 160;

    /// Returns friction with a floor and a slow sensor, for ratios displaced by `by` along `way`.
    fn moved(
        mu: &[Vec<f64>],
        (time_s, normal_n): (&[f64], &[f64]),
        by: f64,
        way: fn(usize, f64) -> f64,
    ) -> TrialFriction {
        // Each instance is in a separate exploration, so no trend is derived between them.
        let middle_s: Vec<f64> = (0..mu.len())
            .map(|instance| 3.0 * instance as f64)
            .collect();
        let samples: Vec<RatioSamples<'_>> = mu
            .iter()
            .enumerate()
            .map(|(instance, mu)| {
                let ratio = ratio(instance);
                let slopes: Vec<f64> = ratio.iter().map(|&of| way(instance, of)).collect();
                let mut ratio_slopes = std::array::from_fn(|_| vec![0.0; SAMPLES]);
                ratio_slopes[0].clone_from(&slopes);
                RatioSamples {
                    ratio: ratio.iter().zip(&slopes).map(|(r, s)| r + by * s).collect(),
                    normal_n,
                    lead: LEAD,
                    mu,
                    ratio_slopes,
                    time_s,
                    middle_s: middle_s[instance],
                }
            })
            .collect();
        fit(&samples, INTERVAL_S).unwrap()
    }

    fn ratio(instance: usize) -> Vec<f64> {
        let depth = 0.5 + 0.1 * instance as f64;
        let at = |n: usize| 1.0 - depth * (0.07 * n as f64).sin().powi(2);
        (0..SAMPLES).map(at).collect()
    }

    /// Compares the derivatives by the contact with refits of floor, lag and each instance's μ0, both when all contacts move
    /// and when only one does.
    #[test]
    fn the_friction_follows_the_contact() {
        let time_s: Vec<f64> = (0..SAMPLES).map(|n| n as f64 * INTERVAL_S).collect();
        let normal_n: Vec<f64> = (0..SAMPLES)
            .map(|n| 0.6 + 0.1 * (0.05 * n as f64).cos())
            .collect();
        let lag = Lag::new(1.2e-3, INTERVAL_S);
        let mu: Vec<Vec<f64>> = (0..3)
            .map(|instance| {
                let lateral = ratio(instance).into_iter().zip(&normal_n);
                let lateral: Vec<f64> = lateral
                    .map(|(ratio, n)| 0.7 * (0.1 + 0.9 * ratio) * n)
                    .collect();
                let mut read = vec![0.0; SAMPLES];
                lag.apply(&lateral, &mut read);
                let inside = read.iter().zip(&normal_n).skip(LEAD);
                inside.map(|(read, n)| read / n).collect()
            })
            .collect();
        let ways: [fn(usize, f64) -> f64; 2] = [
            |_, ratio| ratio * (1.0 - ratio),
            |instance, ratio| if instance == 1 { ratio * ratio } else { 0.0 },
        ];
        for way in ways {
            let by = 1e-4;
            let of = |sign: f64| moved(&mu, (&time_s, &normal_n), sign * by, way);
            let (above, at, below) = (of(1.0), of(0.0), of(-1.0));
            let slope = |above: f64, below: f64| (above - below) / (2.0 * by);
            let parameter = OF_GAP[0];
            let stated: Vector2<f64> = at
                .each
                .iter()
                .map(|of| of.trial_by_contact.column(parameter).into_owned())
                .sum();
            let found = slope(above.floor.value, below.floor.value);
            assert_relative_eq!(stated[FLOOR], found, max_relative = 0.01);
            let found = slope(above.lag_s.value, below.lag_s.value) / MS;
            assert_relative_eq!(stated[LAG_MS], found, max_relative = 0.01, epsilon = 1e-3);
            for (index, of) in at.each.iter().enumerate() {
                let stated = of.by_contact[parameter] + of.by_trial.dot(&stated);
                let found = slope(above.each[index].mu0, below.each[index].mu0);
                assert_relative_eq!(stated, found, max_relative = 0.01, epsilon = 1e-4);
            }
        }
    }
}
