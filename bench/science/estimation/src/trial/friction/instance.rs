//! Friction of one instance for given φ and lag: its best μ0 and the derivatives.
//!
//! Given φ and the lag, the problem is linear in μ0, which is projected out (Golub & Pereyra 1973, with Kaufman's slopes). With
//! the modelled ratio m of Eq. 19, the change c(t) of μ0 within the instance and the lag L of time λ, the friction read for
//! μ0 = 1 is u:
//!
//! ```text
//! u = L[(φ + (1 − φ) m) f_n c]/f_n
//! r = μ0 u − μ,   μ0 = uᵀμ/uᵀu
//! ∂r/∂p = μ0 (1 − u uᵀ/uᵀu) ∂u/∂p,   ∂μ0/∂p = −μ0 uᵀ(∂u/∂p)/uᵀu        p = φ, λ (Kaufman 1975)
//! ```
//!
//! The slopes leave out the terms −u rᵀ(∂u/∂p)/uᵀu and −rᵀ(∂u/∂p)/uᵀu, which vanish with the residuals.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2};

use super::parameters::{FRICTION_PARAMETERS, FrictionParameter};
use super::samples::RatioSamples;
use crate::friction_law::Course;
use crate::lagged_model::GAP_PARAMETERS;
use crate::random_walk::spread;
use contact::first_order_lag::Lag;
use contact::parameters::{LN_FORCE, MS, PARAMETERS};

/// Samples of an instance with the change of μ0 within it.
#[derive(Clone, Copy)]
pub(super) struct Instance<'a> {
    pub(super) samples: &'a RatioSamples<'a>,
    pub(super) course: Course,
    pub(super) interval_s: f64,
}

/// Friction that the sensor reads for a μ0 of 1.
struct UnitFriction {
    values: Vec<f64>,
    /// Slopes by φ and by the lag in ms.
    slopes: [Vec<f64>; FRICTION_PARAMETERS],
}

/// Instance with its best-fitting μ0.
pub(super) struct InstanceFriction<'a> {
    instance: Instance<'a>,
    pub(super) mu0: f64,
    /// Σ of the squares of the friction for a μ0 of 1.
    pub(super) power: f64,
    /// Derivatives of μ0 by φ and the lag.
    pub(super) mu0_slopes: Vector2<f64>,
    /// Friction for a μ0 of 1.
    unit: Vec<f64>,
    pub(super) residuals: Vec<f64>,
    /// Slopes of the residuals by φ and by the lag, with μ0 refitted.
    pub(super) slopes: [Vec<f64>; FRICTION_PARAMETERS],
}

/// Derivatives by the contact of an instance, with φ and the lag held fixed.
pub(super) struct ContactSlopes {
    /// Derivatives of μ0.
    pub(super) mu0: SVector<f64, PARAMETERS>,
    /// Derivatives of the gradient by φ and by the lag.
    pub(super) gradient: SMatrix<f64, FRICTION_PARAMETERS, PARAMETERS>,
}

impl<'a> Instance<'a> {
    /// Fits μ0 for given φ and lag.
    pub(super) fn fit(self, parameters: &Vector2<f64>) -> InstanceFriction<'a> {
        let UnitFriction {
            values: unit,
            slopes: unit_slopes,
        } = self.unit_friction(parameters);
        let mu = self.samples.mu;
        let power = dot(&unit, &unit);
        let mu0 = dot(&unit, mu) / power;
        let mu0_slopes = unit_slopes
            .each_ref()
            .map(|slope| -mu0 * dot(&unit, slope) / power);
        let slopes = unit_slopes.map(|slope| {
            let projection = dot(&unit, &slope) / power;
            slope
                .iter()
                .zip(&unit)
                .map(|(slope, unit)| mu0 * (slope - projection * unit))
                .collect()
        });
        InstanceFriction {
            instance: self,
            mu0,
            power,
            mu0_slopes: Vector2::from(mu0_slopes),
            residuals: unit.iter().zip(mu).map(|(u, mu)| mu0 * u - mu).collect(),
            slopes,
            unit,
        }
    }

    fn unit_friction(&self, parameters: &Vector2<f64>) -> UnitFriction {
        let floor = parameters[FrictionParameter::Floor];
        let lag = self.lag(parameters);
        let ratio = &self.samples.ratio;
        let force = self.lateral_n(ratio, |ratio| floor + (1.0 - floor) * ratio);
        let force_by_floor = self.lateral_n(ratio, |ratio| 1.0 - ratio);
        let n = force.len();
        let (mut reading, mut by_floor, mut by_lag) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        lag.apply(&force, &mut reading);
        lag.apply(&force_by_floor, &mut by_floor);
        lag.slope(&force, &reading, &mut by_lag);
        UnitFriction {
            values: self.friction(&reading, 1.0),
            slopes: [
                self.friction(&by_floor, 1.0),
                self.friction(&by_lag, MS / self.interval_s),
            ],
        }
    }

    fn lag(&self, parameters: &Vector2<f64>) -> Lag {
        Lag::new(parameters[FrictionParameter::LagMs] * MS, self.interval_s)
    }

    /// Returns the lateral force at each sample, lead-in included, for a friction that is a function of `values`, N.
    fn lateral_n(&self, values: &[f64], friction: impl Fn(f64) -> f64) -> Vec<f64> {
        let samples = self.samples;
        let rows = values.iter().zip(samples.normal_n).zip(samples.time_s);
        rows.map(|((&value, n), &time_s)| friction(value) * n * self.course.ratio_at(time_s))
            .collect()
    }

    /// Returns the friction for lateral forces in a given unit, without the lead-in.
    fn friction(&self, lateral: &[f64], unit_n: f64) -> Vec<f64> {
        let samples = self.samples;
        let rows = lateral.iter().zip(samples.normal_n).skip(samples.lead);
        rows.map(|(lateral, n)| lateral * unit_n / n).collect()
    }
}

impl InstanceFriction<'_> {
    pub(super) fn course(&self) -> Course {
        self.instance.course
    }

    pub(super) fn squares(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }

    /// Returns the covariance of μ0, φ and the lag for a μ0 that walks with a diffusivity of 1 per sample; the variance of μ0
    /// excludes its dependence on the other two.
    pub(super) fn walk_covariance(&self, inverse: &Matrix2<f64>) -> Matrix3<f64> {
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

    /// Returns the derivatives by the contact, at the φ and lag of the fit.
    pub(super) fn contact_slopes(&self, parameters: &Vector2<f64>) -> ContactSlopes {
        let Instance { samples, .. } = self.instance;
        let lag = self.instance.lag(parameters);
        let by_ratio = self.mu0 * (1.0 - parameters[FrictionParameter::Floor]);
        let mut reading = vec![0.0; samples.normal_n.len()];
        let (mut by_contact, mut gradient) = (SVector::zeros(), SMatrix::zeros());
        for (parameter, slopes) in GAP_PARAMETERS.into_iter().zip(&samples.ratio_slopes) {
            let lateral = self.instance.lateral_n(slopes, |slope| by_ratio * slope);
            lag.apply(&lateral, &mut reading);
            let mut mu_slopes = self.instance.friction(&reading, 1.0);
            if parameter == LN_FORCE {
                // The measured friction is the lateral force divided by the normal force.
                mu_slopes
                    .iter_mut()
                    .zip(samples.mu)
                    .for_each(|(slope, mu)| *slope += mu);
            }
            // With v = ∂r/∂θ at fixed μ0, φ and λ: ∂μ0/∂θ = −uᵀv/uᵀu. The gradient Jᵀr of φ and λ changes by Jᵀv, and they
            // respond by −(JᵀJ)⁻¹Jᵀv.
            by_contact[parameter] = -dot(&self.unit, &mu_slopes) / self.power;
            for (row, slopes) in self.slopes.iter().enumerate() {
                gradient[(row, parameter)] = dot(slopes, &mu_slopes);
            }
        }
        ContactSlopes {
            mu0: by_contact,
            gradient,
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
