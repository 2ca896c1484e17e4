//! Fit of the measured friction to the modelled ratio: μ0, the floor below which friction does not fall, and the lag of the
//! lateral force.
//!
//! The lateral force μ f_n is read through the first-order lag of its sensor. φ and the lag are shared by a trial, μ0 belongs
//! to an instance. All three are fitted to the measured friction after the impedance and do not affect its fit.
//!
//! 1. Given the change of μ0 within each instance, φ and the lag are searched (`problem`) with every instance's best μ0
//!    (`instance`). That change follows the trend of μ0 between instances, in two iterations.
//! 2. A random walk of μ0 within the instance ([`random_walk`](crate::random_walk)), from the values of μ0 of step 1, widens
//!    the errors (`errors`) and does not change the fit.

mod errors;
mod instance;
mod parameters;
mod problem;
mod samples;
mod trial_friction;

use crate::friction_law::Course;
use crate::random_walk::{Mean, Means};
use crate::trend::{NEIGHBOURS_S, rate_about};

use errors::Errors;
use instance::Instance;
use problem::FrictionProblem;
use trial_friction::RestFriction;

pub(super) use parameters::{FRICTION_PARAMETERS, FrictionParameter};
pub(super) use samples::{RatioSamples, TrialSamples};
pub(super) use trial_friction::{SharedFriction, TrialFriction};

/// Ratio of the diffusivity of μ0 within an instance to that between instances. Friction depends on the finger's speed; the
/// hand's tremor of 8 to 12 Hz changes speed within 60 ms, but hardly its mean over an instance.
const DIFFUSIVITY_RATIO: f64 = 2.0;

/// Number of iterations in which the trend of μ0 between instances is applied within each.
const TREND_ITERATIONS: usize = 2;

/// Fits φ, the lag and every instance's μ0 to the measured friction; `None` if the fit does not converge.
pub(super) fn fit(samples: &TrialSamples<'_>) -> Option<TrialFriction> {
    let steady_course = |instance: &RatioSamples<'_>| Course {
        per_s: 0.0,
        middle_s: instance.middle_s,
    };
    let mut courses: Vec<Course> = samples.instances.iter().map(steady_course).collect();
    for _ in 0..TREND_ITERATIONS {
        let friction = fit_with_courses(samples, &courses, 0.0)?;
        follow_trend(&mut courses, &friction);
    }
    let steady_friction = fit_with_courses(samples, &courses, 0.0)?;
    let wander_per_s = wander_per_s(samples, &courses, &steady_friction);
    fit_with_courses(samples, &courses, wander_per_s)
}

/// Applies the relative rate at which μ0 changes between instances within each instance.
fn follow_trend(courses: &mut [Course], friction: &TrialFriction) {
    let times_s: Vec<f64> = courses.iter().map(|course| course.middle_s).collect();
    let mu0 = |k: usize| friction.instances[k].mu0;
    for (index, course) in courses.iter_mut().enumerate() {
        course.per_s = rate_about(index, &times_s, mu0) / mu0(index);
    }
}

/// Returns the variance of ln μ0 that a random walk adds per second within an instance, 1/s.
fn wander_per_s(samples: &TrialSamples<'_>, courses: &[Course], friction: &TrialFriction) -> f64 {
    let instances = &samples.instances;
    let times_s: Vec<f64> = courses.iter().map(|course| course.middle_s).collect();
    let per_s: Vec<f64> = courses.iter().map(|course| course.per_s).collect();
    let mean = |instance: &RestFriction| Mean {
        value: instance.mu0,
        variance: instance.mu0_variance,
    };
    let mu0: Vec<Mean> = friction.instances.iter().map(mean).collect();
    let sample_count: usize = instances.iter().map(|instance| instance.mu.len()).sum();
    let means = Means {
        times_s: &times_s,
        stretch_s: samples.interval_s * sample_count as f64 / instances.len() as f64,
        max_gap_s: NEIGHBOURS_S,
        values: &mu0,
        per_s: &per_s,
    };
    DIFFUSIVITY_RATIO * means.diffusivity_per_s()
}

/// Fits the friction for a given change of μ0 within each instance, with errors that include a random walk of μ0.
fn fit_with_courses(
    samples: &TrialSamples<'_>,
    courses: &[Course],
    wander_per_s: f64,
) -> Option<TrialFriction> {
    let instances: Vec<Instance<'_>> = samples
        .instances
        .iter()
        .zip(courses)
        .map(|(instance, &course)| Instance {
            samples: instance,
            course,
            interval_s: samples.interval_s,
        })
        .collect();
    let minimum = FrictionProblem::minimise(&instances)?;
    let fits = minimum.fits();
    let errors = Errors::new(&minimum, &fits, wander_per_s * samples.interval_s)?;
    Some(TrialFriction {
        shared: errors.shared(),
        instances: errors.instances(&fits),
    })
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use nalgebra::Vector2;

    use super::*;
    use crate::lagged_model::GAP_PARAMETERS;
    use contact::first_order_lag::Lag;
    use contact::parameters::MS;

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
        let instances = mu
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
        fit(&TrialSamples {
            instances,
            interval_s: INTERVAL_S,
        })
        .unwrap()
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
            let difference = slope(above.shared.floor.value, below.shared.floor.value);
            assert_relative_eq!(
                trial_slopes[FrictionParameter::Floor],
                difference,
                max_relative = 0.01
            );
            let difference = slope(above.shared.lag_s.value, below.shared.lag_s.value) / MS;
            assert_relative_eq!(
                trial_slopes[FrictionParameter::LagMs],
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
