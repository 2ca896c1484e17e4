//! Fit of the measured friction to the modelled ratio: μ0, the floor below which friction does not fall, and the lag of the
//! lateral force.
//!
//! The lateral force μ f_n is read through the first-order lag of its sensor. φ and the lag are shared by a trial, μ0 belongs
//! to an instance. All three are fitted to the measured friction after the impedance and do not affect its fit. Given φ and
//! the lag, the problem is linear in the instance's μ0, which is projected out (Golub & Pereyra 1973, with Kaufman's slopes).
//!
//! With the modelled ratio m of Eq. 19, the change c(t) of μ0 within the instance and the lag L of time λ, the friction read
//! for μ0 = 1 is u:
//!
//! ```text
//! u = L[(φ + (1 − φ) m) f_n c]/f_n
//! r = μ0 u − μ,   μ0 = uᵀμ/uᵀu
//! ∂r/∂p = μ0 (1 − u uᵀ/uᵀu) ∂u/∂p,   ∂μ0/∂p = −μ0 uᵀ(∂u/∂p)/uᵀu        p = φ, λ (Kaufman 1975)
//! ```
//!
//! The slopes leave out the terms −u rᵀ(∂u/∂p)/uᵀu and −rᵀ(∂u/∂p)/uᵀu, which vanish with the residuals. The sum
//! Σ r² + s² ((φ/0.3)² + (λ/5 ms)²), with s² the residuals' variance, is minimised over φ and λ: s² times −2 ln of the
//! posterior for normal residuals and normal priors about 0. A random walk of μ0 within the instance (`random_walk`) widens the
//! errors and does not change the fit.

use crate::first_order_lag::Lag;
use crate::random_walk::{Means, spread};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, Matrix2, Matrix3, OMatrix, SMatrix, SVector, U2, Vector2};
use num_complex::Complex64;

use crate::friction_law::{Course, FrictionLaw};
use crate::lagged_model::GAP_PARAMETERS;
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
    /// ∂`ratio`/∂parameter, for the parameters in [`GAP_PARAMETERS`].
    pub(super) ratio_slopes: [Vec<f64>; GAP_PARAMETERS.len()],
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
    pub(super) instances: Vec<RestFriction>,
}

/// Number of parameters shared by a trial: φ and the lag.
pub(super) const FRICTION_PARAMETERS: usize = 2;

/// μ0 of an instance, with its variances and derivatives.
pub(super) struct RestFriction {
    /// μ0 at the middle of the instance.
    pub(super) mu0: f64,
    /// Change of μ0 within the instance.
    pub(super) course: Course,
    /// Variance of μ0 from the scatter of the measured friction, with φ and the lag held fixed and no random walk of μ0.
    mu0_variance: f64,
    /// Covariance of μ0 and φ from the scatter of the measured friction.
    pub(super) scatter: Matrix2<f64>,
    /// Derivatives of μ0 by φ and the lag.
    pub(super) by_trial: SVector<f64, FRICTION_PARAMETERS>,
    /// Derivatives of μ0 by the instance's contact, with φ and the lag held fixed.
    pub(super) by_contact: SVector<f64, PARAMETERS>,
    /// Derivatives of φ and the lag by the instance's contact.
    pub(super) trial_by_contact: SMatrix<f64, FRICTION_PARAMETERS, PARAMETERS>,
}

impl TrialFriction {
    /// Returns an instance's friction law for an exactly known contact.
    pub(super) fn law(&self, index: usize) -> FrictionLaw<PARAMETERS> {
        let instance = &self.instances[index];
        FrictionLaw {
            mu0: instance.mu0,
            course: instance.course,
            floor: self.floor.value,
            lag_s: self.lag_s.value,
            slopes: instance.by_contact.into(),
            floor_slopes: [0.0; PARAMETERS],
            scatter: instance.scatter,
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
const DIFFUSIVITY_RATIO: f64 = 2.0;

/// Number of iterations in which the trend of μ0 between instances is applied within each.
const TREND_ITERATIONS: usize = 2;

/// Fits φ, the lag and every instance's μ0 to the measured friction; `None` if the fit does not converge.
pub(super) fn fit(instances: &[RatioSamples<'_>], interval_s: f64) -> Option<TrialFriction> {
    let times_s: Vec<f64> = instances.iter().map(|instance| instance.middle_s).collect();
    let course_at = |middle_s: f64, per_s: f64| Course { per_s, middle_s };
    let mut courses: Vec<Course> = times_s
        .iter()
        .map(|&middle_s| course_at(middle_s, 0.0))
        .collect();
    for _ in 0..TREND_ITERATIONS {
        let friction = fit_with_courses(&courses, 0.0, instances, interval_s)?;
        let mu0 = |k: usize| friction.instances[k].mu0;
        for (index, course) in courses.iter_mut().enumerate() {
            course.per_s = rate_about(index, &times_s, mu0) / mu0(index);
        }
    }
    let steady = fit_with_courses(&courses, 0.0, instances, interval_s)?;
    let reading = |instance: &RestFriction| (instance.mu0, instance.mu0_variance);
    let mu0: Vec<(f64, f64)> = steady.instances.iter().map(reading).collect();
    let per_s: Vec<f64> = courses.iter().map(|course| course.per_s).collect();
    let samples: usize = instances.iter().map(|instance| instance.mu.len()).sum();
    let stretch_s = interval_s * samples as f64 / instances.len() as f64;
    let means = Means {
        times_s: &times_s,
        each_s: stretch_s,
        apart_s: NEIGHBOURS_S,
        values: &mu0,
        per_s: &per_s,
    };
    let wander_per_s = DIFFUSIVITY_RATIO * means.diffusivity_per_s();
    fit_with_courses(&courses, wander_per_s, instances, interval_s)
}

fn fit_with_courses(
    courses: &[Course],
    wander_per_s: f64,
    instances: &[RatioSamples<'_>],
    interval_s: f64,
) -> Option<TrialFriction> {
    let n: usize = instances.iter().map(|instance| instance.mu.len()).sum();
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
    let squares: f64 = problem.fits().iter().map(InstanceFriction::squares).sum();
    problem.std = (squares / freedom).sqrt().max(f64::MIN_POSITIVE.sqrt());
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    if !report.termination.was_successful() {
        return None;
    }
    let fits = problem.fits();
    let residuals: Vec<Complex64> = fits
        .iter()
        .flat_map(|fit| fit.residuals.iter().map(|&r| r.into()))
        .collect();
    let squares: f64 = residuals.iter().map(Complex64::norm_sqr).sum();
    let variance = squares / freedom * correlation(&residuals);
    let jacobian = problem.jacobian()?;
    let inverse = jacobian.tr_mul(&jacobian).try_inverse()?;
    let walks: Vec<Matrix3<f64>> = fits
        .iter()
        .map(|fit| fit.walk_covariance(&inverse) * (wander_per_s * interval_s))
        .collect();
    let trial_block = |walk: &Matrix3<f64>| walk.fixed_view::<2, 2>(1, 1).into_owned();
    let covariance = inverse * variance + walks.iter().map(trial_block).sum::<Matrix2<f64>>();
    let element = |i: usize, j: usize| covariance[(i, j)];
    let samples_and_walks = instances.iter().zip(courses).zip(&walks);
    let rest_friction =
        fits.iter()
            .zip(samples_and_walks)
            .map(|(fit, ((samples, course), walk))| {
                // The variance of μ0 combines its own scatter with that of φ and the lag. For δμ0 = e + dᵀδp with d = ∂μ0/∂p
                // and k = Cov(e, δp), which only the walk has: Var μ0 = Var e + 2 dᵀk + dᵀCov(p) d and
                // Cov(μ0, p) = Cov(p) d + k.
                let mu0_slopes = Vector2::from(fit.mu0_slopes);
                let walk_cross = walk.fixed_view::<2, 1>(1, 0);
                let mu0_variance = variance / fit.power;
                let total_variance = mu0_variance
                    + walk[(0, 0)]
                    + 2.0 * mu0_slopes.dot(&walk_cross)
                    + mu0_slopes.dot(&(covariance * mu0_slopes));
                let cross = covariance * mu0_slopes + walk_cross;
                let (by_contact, gradient) = problem.contact_slopes(samples, course, fit);
                RestFriction {
                    mu0: fit.mu0,
                    course: *course,
                    mu0_variance,
                    scatter: Matrix2::new(
                        total_variance,
                        cross[FLOOR],
                        cross[FLOOR],
                        element(FLOOR, FLOOR),
                    ),
                    by_trial: mu0_slopes,
                    by_contact,
                    trial_by_contact: -inverse * gradient,
                }
            });
    Some(TrialFriction {
        floor: Uncertain {
            value: problem.parameters[FLOOR],
            std: element(FLOOR, FLOOR).sqrt(),
        },
        lag_s: Uncertain {
            value: problem.parameters[LAG_MS] * MS,
            std: element(LAG_MS, LAG_MS).sqrt() * MS,
        },
        instances: rest_friction.collect(),
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
    fn walk_covariance(&self, inverse: &Matrix2<f64>) -> Matrix3<f64> {
        let mean_weight = 1.0 / self.unit.len() as f64;
        // A walk w of ln μ0 changes the measured friction by μ0 u w, and with it μ0 = uᵀμ/uᵀu by μ0 Σ u² w/uᵀu, of which the
        // walk's mean, μ0 Σ w/n, is the true change of the instance's μ0 and no error. φ and λ change by
        // (JᵀJ)⁻¹ Σ (∂r/∂p) μ0 u w; J includes the rows of the priors.
        let mu0_weights = self.unit.iter().map(|u| u * u / self.power - mean_weight);
        let mu0_weights: Vec<f64> = mu0_weights.map(|weight| weight * self.mu0).collect();
        let [by_floor, by_lag] = &self.slopes;
        let slopes = by_floor.iter().zip(by_lag).zip(&self.unit);
        let trial_weights: Vec<Vector2<f64>> = slopes
            .map(|((floor, lag), unit)| inverse * Vector2::new(*floor, *lag) * (self.mu0 * unit))
            .collect();
        spread(&mu0_weights, &trial_weights)
    }
}

impl FrictionProblem<'_> {
    fn fits(&self) -> Vec<InstanceFriction> {
        let instances = self.instances.iter().zip(self.courses);
        instances
            .map(|(samples, course)| self.instance(samples, course))
            .collect()
    }

    fn instance(&self, samples: &RatioSamples<'_>, course: &Course) -> InstanceFriction {
        let floor = self.parameters[FLOOR];
        let lag = Lag::new(self.parameters[LAG_MS] * MS, self.interval_s);
        let n = samples.normal_n.len();
        let lateral = |law: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let rows = samples
                .ratio
                .iter()
                .zip(samples.normal_n)
                .zip(samples.time_s);
            rows.map(|((&ratio, n), &time_s)| law(ratio) * n * course.ratio_at(time_s))
                .collect()
        };
        let force = lateral(&|ratio| floor + (1.0 - floor) * ratio);
        let force_by_floor = lateral(&|ratio| 1.0 - ratio);
        let (mut reading, mut by_floor, mut by_lag) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        lag.apply(&force, &mut reading);
        lag.apply(&force_by_floor, &mut by_floor);
        lag.slope(&force, &reading, &mut by_lag);
        let friction = |force: &[f64], unit: f64| -> Vec<f64> {
            let rows = force.iter().zip(samples.normal_n).skip(samples.lead);
            rows.map(|(lateral, n)| lateral * unit / n).collect()
        };
        let unit = friction(&reading, 1.0);
        let unit_slopes = [
            friction(&by_floor, 1.0),
            friction(&by_lag, MS / self.interval_s),
        ];
        let power = dot(&unit, &unit);
        let mu0 = dot(&unit, samples.mu) / power;
        let mu0_slopes = [0, 1].map(|p| -mu0 * dot(&unit, &unit_slopes[p]) / power);
        let slopes = unit_slopes.map(|slope| {
            let projection = dot(&unit, &slope) / power;
            slope
                .iter()
                .zip(&unit)
                .map(|(slope, unit)| mu0 * (slope - projection * unit))
                .collect()
        });
        InstanceFriction {
            mu0,
            power,
            mu0_slopes,
            residuals: unit
                .iter()
                .zip(samples.mu)
                .map(|(u, mu)| mu0 * u - mu)
                .collect(),
            slopes,
            unit,
        }
    }

    /// Returns the derivatives by the contact of an instance's μ0, with φ and the lag held fixed, and of the gradient by those
    /// two.
    fn contact_slopes(
        &self,
        samples: &RatioSamples<'_>,
        course: &Course,
        fit: &InstanceFriction,
    ) -> (
        SVector<f64, PARAMETERS>,
        SMatrix<f64, FRICTION_PARAMETERS, PARAMETERS>,
    ) {
        let lag = Lag::new(self.parameters[LAG_MS] * MS, self.interval_s);
        let by_ratio = fit.mu0 * (1.0 - self.parameters[FLOOR]);
        let mut reading = vec![0.0; samples.normal_n.len()];
        let (mut by_contact, mut gradient) = (SVector::zeros(), SMatrix::zeros());
        for (parameter, slopes) in GAP_PARAMETERS.into_iter().zip(&samples.ratio_slopes) {
            let rows = slopes.iter().zip(samples.normal_n).zip(samples.time_s);
            let lateral: Vec<f64> = rows
                .map(|((slope, n), &time_s)| by_ratio * slope * n * course.ratio_at(time_s))
                .collect();
            lag.apply(&lateral, &mut reading);
            let mut mu_slopes: Vec<f64> = reading
                .iter()
                .zip(samples.normal_n)
                .skip(samples.lead)
                .map(|(reading, n)| reading / n)
                .collect();
            if parameter == LN_FORCE {
                // The measured friction is the lateral force divided by the normal force.
                mu_slopes
                    .iter_mut()
                    .zip(samples.mu)
                    .for_each(|(slope, mu)| *slope += mu);
            }
            // With v = ∂r/∂θ at fixed μ0, φ and λ: ∂μ0/∂θ = −uᵀv/uᵀu. The gradient Jᵀr of φ and λ changes by Jᵀv, and they
            // respond by −(JᵀJ)⁻¹Jᵀv.
            by_contact[parameter] = -dot(&fit.unit, &mu_slopes) / fit.power;
            for (row, slopes) in fit.slopes.iter().enumerate() {
                gradient[(row, parameter)] = dot(slopes, &mu_slopes);
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

    /// Returns friction with a floor and a slow sensor, for ratios displaced by `step` along `direction`.
    fn friction_at(
        mu: &[Vec<f64>],
        (time_s, normal_n): (&[f64], &[f64]),
        step: f64,
        direction: fn(usize, f64) -> f64,
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
                let slopes: Vec<f64> = ratio
                    .iter()
                    .map(|&value| direction(instance, value))
                    .collect();
                let mut ratio_slopes = std::array::from_fn(|_| vec![0.0; SAMPLES]);
                ratio_slopes[0].clone_from(&slopes);
                RatioSamples {
                    ratio: ratio
                        .iter()
                        .zip(&slopes)
                        .map(|(r, s)| r + step * s)
                        .collect(),
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
        let ratio_at = |n: usize| 1.0 - depth * (0.07 * n as f64).sin().powi(2);
        (0..SAMPLES).map(ratio_at).collect()
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
                let mut reading = vec![0.0; SAMPLES];
                lag.apply(&lateral, &mut reading);
                let rows = reading.iter().zip(&normal_n).skip(LEAD);
                rows.map(|(reading, n)| reading / n).collect()
            })
            .collect();
        let directions: [fn(usize, f64) -> f64; 2] = [
            |_, ratio| ratio * (1.0 - ratio),
            |instance, ratio| if instance == 1 { ratio * ratio } else { 0.0 },
        ];
        for direction in directions {
            let step = 1e-4;
            let friction =
                |sign: f64| friction_at(&mu, (&time_s, &normal_n), sign * step, direction);
            let (above, middle, below) = (friction(1.0), friction(0.0), friction(-1.0));
            let slope = |above: f64, below: f64| (above - below) / (2.0 * step);
            let parameter = GAP_PARAMETERS[0];
            let trial_slopes: Vector2<f64> = middle
                .instances
                .iter()
                .map(|instance| instance.trial_by_contact.column(parameter).into_owned())
                .sum();
            let difference = slope(above.floor.value, below.floor.value);
            assert_relative_eq!(trial_slopes[FLOOR], difference, max_relative = 0.01);
            let difference = slope(above.lag_s.value, below.lag_s.value) / MS;
            assert_relative_eq!(
                trial_slopes[LAG_MS],
                difference,
                max_relative = 0.01,
                epsilon = 1e-3
            );
            for (index, instance) in middle.instances.iter().enumerate() {
                let mu0_slope =
                    instance.by_contact[parameter] + instance.by_trial.dot(&trial_slopes);
                let difference = slope(above.instances[index].mu0, below.instances[index].mu0);
                assert_relative_eq!(mu0_slope, difference, max_relative = 0.01, epsilon = 1e-4);
            }
        }
    }
}
