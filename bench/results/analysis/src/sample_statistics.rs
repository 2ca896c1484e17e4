//! Statistics over all samples of a recording by one method.

use correlations::{Coefficient, r_squared_complex};
use estimation::ModelledSeries;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::estimate::InstanceAnalysis;
use crate::method::Method;
use crate::recording_series::{EstimateSeries, SampledInstance};
use crate::sampled_quantity::SampledQuantity;

/// Statistics over the samples of all instances of a recording that a method estimates; NaN without any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SampleStatistics {
    /// Spearman's coefficient of |Z_m| and the measured friction.
    pub abs_z_m_mu: f64,
    /// Spearman's coefficient of the stiffness and the measured friction.
    pub k_c_mu: f64,
    /// Spearman's coefficient of the estimated and the measured friction.
    pub mu_estimated_mu: f64,
    /// R² of the impedance modelled with the participant's average σ_t; NaN before it is known.
    pub r2_averaged: f64,
}

impl Default for SampleStatistics {
    fn default() -> Self {
        Self {
            abs_z_m_mu: f64::NAN,
            k_c_mu: f64::NAN,
            mu_estimated_mu: f64::NAN,
            r2_averaged: f64::NAN,
        }
    }
}

/// Models of an instance; `None` where the average σ_t allows no such contact.
pub type AveragedModels = ByMethod<Option<ModelledSeries>>;

/// Agreement of estimated with measured friction over all samples that a method estimates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MuAgreement {
    /// R² about the line of slope 1; `None` if the measured friction is constant.
    pub r2: Option<f64>,
    /// Number of samples.
    pub samples: usize,
}

/// A value for each method.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ByMethod<T> {
    /// Value of the published method.
    pub paper: T,
    /// Value of the dynamic method.
    pub dynamic: T,
    /// Value of the fit of the whole trial.
    pub trial: T,
}

impl<T> ByMethod<T> {
    /// Makes the value of each method.
    pub fn new(mut value: impl FnMut(Method) -> T) -> Self {
        Self {
            paper: value(Method::Paper),
            dynamic: value(Method::Dynamic),
            trial: value(Method::Trial),
        }
    }

    /// Returns the value of a method.
    pub fn get(&self, method: Method) -> &T {
        match method {
            Method::Paper => &self.paper,
            Method::Dynamic => &self.dynamic,
            Method::Trial => &self.trial,
        }
    }

    /// Returns the value of a method.
    pub fn get_mut(&mut self, method: Method) -> &mut T {
        match method {
            Method::Paper => &mut self.paper,
            Method::Dynamic => &mut self.dynamic,
            Method::Trial => &mut self.trial,
        }
    }
}

/// Instance that a method estimates, with its samples.
#[derive(Debug, Clone, Copy)]
pub struct EstimatedSamples<'a> {
    /// Number of the instance in its recording, from 0.
    pub number: usize,
    /// Samples of the instance.
    pub instance: &'a SampledInstance,
    /// Estimates of the samples.
    pub estimate: &'a EstimateSeries,
}

/// Returns the instances with an estimate by a method, as [`InstanceAnalysis::estimate_by`] judges.
pub fn estimated_samples<'a>(
    instances: &'a [InstanceAnalysis],
    samples: &'a [SampledInstance],
    method: Method,
) -> impl Iterator<Item = EstimatedSamples<'a>> {
    let pairs = instances.iter().zip(samples).enumerate();
    pairs.filter_map(move |(number, (instance, samples))| {
        instance.estimate_by(method)?;
        Some(EstimatedSamples {
            number,
            instance: samples,
            estimate: samples.estimate(method)?,
        })
    })
}

impl SampleStatistics {
    /// Computes the statistics of a recording by a method, except those with its participant's average σ_t.
    pub(crate) fn new(
        instances: &[InstanceAnalysis],
        samples: &[SampledInstance],
        method: Method,
    ) -> Self {
        let estimated: Vec<_> = estimated_samples(instances, samples, method).collect();
        let joined = |quantity: SampledQuantity| -> Vec<f64> {
            let values = estimated
                .iter()
                .flat_map(|e| quantity.values(&e.instance.samples, method, e.estimate));
            values.collect()
        };
        let mu = joined(SampledQuantity::Mu);
        let correlation = |quantity: SampledQuantity| {
            let correlation = Coefficient::Spearman.correlate(&joined(quantity), &mu);
            correlation.map_or(f64::NAN, |correlation| correlation.rho)
        };
        Self {
            abs_z_m_mu: correlation(SampledQuantity::AbsZM),
            k_c_mu: correlation(SampledQuantity::Stiffness),
            mu_estimated_mu: correlation(SampledQuantity::MuEstimated),
            r2_averaged: f64::NAN,
        }
    }
}

/// Returns R² of the impedance modelled with the participant's average σ_t over the samples of a recording by a method; NaN if an
/// instance has no such model.
pub(crate) fn r2_averaged(
    instances: &[InstanceAnalysis],
    samples: &[SampledInstance],
    models: &[AveragedModels],
    method: Method,
) -> f64 {
    let (mut measured, mut modelled) = (Vec::<Complex64>::new(), Vec::<Complex64>::new());
    for estimated in estimated_samples(instances, samples, method) {
        let Some(model) = models
            .get(estimated.number)
            .and_then(|m| m.get(method).as_ref())
        else {
            return f64::NAN;
        };
        measured.extend(estimated.instance.samples.z_m(method));
        modelled.extend(&model.z_m_n_s_per_m);
    }
    r_squared_complex(&measured, &modelled)
}
