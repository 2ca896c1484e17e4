//! Estimates an instance by `paper` and `dynamic`, and converts the result of a trial's fit to the same form.

use contact::uncertain::{LogUncertain, Uncertain};
use contact::{AssumedConstants, Contact};
use correlations::{Coefficient, Correlation};
use estimation::paper::RestReading;
use estimation::{
    Agreement, EstimatedSeries, FitConditions, FitError, FitVerdict, InstanceFit, InstanceMisfit,
    Sensitivities, dynamic, paper,
};
use num_complex::Complex64;
use plausibility::{RoughnessError, roughness};
use protocols::{Direction, Instance};
use serde::{Deserialize, Serialize};

use crate::analysis_settings::Settings;
use crate::instance::PreparedInstance;
use crate::measurements::FrameSeries;
pub use crate::method::Method;
use crate::recording_series::{EstimateSeries, SampledInstance};
use crate::sampled_quantity::Extents;
use crate::under_finger::UnderFinger;
use crate::within_laws::WithinLaws;
use contact::skin_motion::{Impedances, SkinMotion};

/// Length at either end of an instance that is averaged for changes over it, s: the same as for Z_t at rest.
const EDGE_S: f64 = 5e-3;

/// Instance with its estimates. Its samples are a [`SampledInstance`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct InstanceAnalysis {
    /// Number of its exploration in the recording, from 0.
    pub exploration: usize,
    /// Direction of the slide.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Mean normal force, N.
    pub normal_n: f64,
    /// Fall of the measured friction: mean of the first 5 ms minus mean of the last 5 ms.
    pub delta_mu: f64,
    /// Number of samples.
    pub samples: usize,
    /// Measured friction.
    pub mu: EdgeMeans,
    /// Amplitude under the finger at the crest, peak, m: mean of the last 5 ms.
    pub amplitude_at_crest_m: f64,
    /// Mean ratio of the amplitude under the finger to that at the pickup.
    pub amplitude_ratio: f64,
    /// Estimate by the published method.
    pub paper: InstanceEstimate,
    /// Estimate by the dynamic method.
    pub dynamic: InstanceEstimate,
    /// Estimate by the fit of the whole trial, from the data that `dynamic` uses; `None` if that fit cannot be used.
    pub trial: Option<InstanceEstimate>,
    /// Estimates by that fit with the laws as published taken as true; `None` if that fit cannot be used, or if these laws do not hold.
    pub within_laws: Option<WithinLaws>,
}

/// An instance by one method.
#[derive(Debug, Clone, Copy)]
pub struct MethodEstimate<'a> {
    /// The instance.
    pub instance: &'a InstanceAnalysis,
    /// The method.
    pub method: Method,
    /// The method's estimate of the instance.
    pub estimate: &'a InstanceEstimate,
}

impl InstanceAnalysis {
    /// Returns the estimate by a method; `None` where its fit cannot be used.
    pub fn estimate(&self, method: Method) -> Option<&InstanceEstimate> {
        self.fit(method)
            .filter(|estimate| estimate.verdict.is_usable())
    }

    /// Returns the estimate by a method, also if its fit cannot be used; `None` without one.
    pub(crate) fn fit(&self, method: Method) -> Option<&InstanceEstimate> {
        match method {
            Method::Paper => Some(&self.paper),
            Method::Dynamic => Some(&self.dynamic),
            Method::Trial => self.trial.as_ref(),
        }
    }

    pub(crate) fn fit_mut(&mut self, method: Method) -> Option<&mut InstanceEstimate> {
        match method {
            Method::Paper => Some(&mut self.paper),
            Method::Dynamic => Some(&mut self.dynamic),
            Method::Trial => self.trial.as_mut(),
        }
    }

    /// Returns the reason why `paper` or `dynamic` cannot be used; `None` if both can.
    pub fn usability_error(&self) -> Option<EstimateError> {
        let single_fits = [
            (Method::Paper, &self.paper),
            (Method::Dynamic, &self.dynamic),
        ];
        let (method, estimated) = single_fits
            .into_iter()
            .find(|(_, estimated)| !estimated.verdict.is_usable())?;
        Some(EstimateError::Unusable {
            method,
            verdict: estimated.verdict.clone(),
        })
    }

    /// Returns the instance by a method; `None` if its fit cannot be used.
    ///
    /// An estimate with a σ_t larger than any skin's is not one: the data do not follow the method's laws.
    pub fn estimate_by(&self, method: Method) -> Option<MethodEstimate<'_>> {
        let estimate = self.estimate(method)?;
        estimate.sigma_t().is_ok().then_some(MethodEstimate {
            instance: self,
            method,
            estimate,
        })
    }

    /// Returns the mean ratio of the amplitude used by a method to that at the pickup: 1 for `paper`.
    pub fn mean_amplitude_ratio(&self, method: Method) -> f64 {
        match method {
            Method::Paper => 1.0,
            Method::Dynamic | Method::Trial => self.amplitude_ratio,
        }
    }

    /// Returns all estimates.
    pub fn estimates(&self) -> impl Iterator<Item = MethodEstimate<'_>> {
        Method::ALL
            .into_iter()
            .filter_map(|method| self.estimate_by(method))
    }
}

/// Change of the plate's impedance relative to the unloaded plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlateOffset {
    /// Offset added to Z_p, N·s/m.
    pub n_s_per_m: Complex64,
    /// Standard errors of its real and imaginary part, N·s/m.
    pub std_n_s_per_m: Complex64,
    /// Shift of the resonance relative to the unloaded plate, Hz.
    pub resonance_shift_hz: f64,
    /// Standard error of the shift, Hz.
    pub resonance_shift_std_hz: f64,
}

/// Changes over an instance, from the mean of its first 5 ms to that of its last. All are positive if the rise of
/// the amplitude lifts the skin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Deltas {
    /// Fall of |Z_m| as used by the method, N·s/m.
    pub abs_z_m_n_s_per_m: f64,
    /// Fall of Re Z_m, N·s/m.
    pub re_z_m_n_s_per_m: f64,
    /// Fall of |Im Z_m|, N·s/m.
    pub abs_im_z_m_n_s_per_m: f64,
    /// Rise of the gap, m.
    pub gap_m: f64,
    /// Rise of the reaction force's amplitude (Huloux 2021, Eq. 10), N.
    pub reaction_force_n: f64,
    /// Rise of the squeeze film's mean force (Eq. 14), N.
    pub squeeze_n: f64,
    /// Fall of the estimated friction.
    pub mu: f64,
}

/// Model with the average σ_t over a participant's instances.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Averaged {
    /// Average σ_t, m; NaN if no estimate of the participant by the method has a σ_t that a skin can have.
    pub(crate) sigma_t_m: f64,
    /// R² of its impedance, as for the fit; NaN without a model.
    pub r2_impedance: f64,
}

impl Averaged {
    /// Returns the average σ_t, m.
    ///
    /// # Errors
    /// No estimate of the participant by the method has a σ_t that a skin can have.
    pub fn sigma_t_m(&self) -> Result<f64, AverageError> {
        let average_m = self.sigma_t_m;
        average_m
            .is_finite()
            .then_some(average_m)
            .ok_or(AverageError)
    }
}

/// No estimate of a participant by a method has a σ_t that a skin can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no usable estimate of the participant by this method has a σ_t that a skin can have")]
pub struct AverageError;

/// Estimate of an instance by one method.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct InstanceEstimate {
    /// Verdict on whether the parameters can be used.
    pub verdict: FitVerdict,
    /// σ_t at which the fit ended, m: [`sigma_t`](Self::sigma_t) returns it if a skin can have it.
    sigma_t_m: f64,
    /// Standard error of σ_t, m.
    sigma_t_std_m: f64,
    /// Z_t, N·s/m.
    pub z_t_n_s_per_m: Complex64,
    /// Standard errors of the real and imaginary part of Z_t, N·s/m.
    pub z_t_std_n_s_per_m: Complex64,
    /// τ and its standard error, s; `None` for `paper`.
    pub tau_s: Option<(f64, f64)>,
    /// Constants of skin and air: assumed, except S, q0 and η for `trial`, which fits them.
    pub skin: AssumedConstants,
    /// Offset of the plate; `None` for `paper`.
    pub plate_offset: Option<PlateOffset>,
    /// μ0.
    pub mu0: f64,
    /// Standard error of μ0.
    pub mu0_std: f64,
    /// Samples from which Z_m⁰ was read, for `paper`.
    pub rest: Option<RestReading>,
    /// Z_p that the estimate subtracts, including the plate's offset, N·s/m.
    pub z_p_n_s_per_m: Complex64,
    /// Z_m⁰ − Z_p, N·s/m: Z_t for a rigid contact at rest, to compare with Eq. 21.
    pub rigid_z_t_n_s_per_m: Complex64,
    /// Agreement of fitted and measured values.
    pub agreement: Agreement,
    /// Signs that the instance does not follow the laws of `paper` or `dynamic`; none for `trial`, which has signs of a whole
    /// recording.
    pub misfit: Vec<InstanceMisfit>,
    /// Extents of the sampled quantities.
    pub extents: Extents,
    /// Gap at the crest, m: mean of the last 5 ms.
    pub gap_at_crest_m: f64,
    /// Means of measured and estimated friction over the samples at rest, for `paper`.
    pub mu_at_rest: Option<(f64, f64)>,
    /// Model with the participant's average σ_t.
    pub averaged: Averaged,
    /// Correlation of estimated with measured friction; `None` if either is constant.
    pub spearman_mu: Option<Correlation>,
    /// Changes over the instance.
    pub deltas: Deltas,
    /// Sensitivities of σ_t, Z_t and τ to the assumed constants; `None` if a refit near the assumed values fails.
    pub sensitivities: Option<Sensitivities>,
}

/// Value of σ_t with its standard error, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SigmaT {
    /// Value, m.
    pub value_m: f64,
    /// Standard error, m.
    pub std_m: f64,
}

impl InstanceEstimate {
    /// Returns σ_t.
    ///
    /// # Errors
    /// [`RoughnessError`] if no skin has it. The estimate has then neither a gap nor a force of the film.
    pub fn sigma_t(&self) -> Result<SigmaT, RoughnessError> {
        roughness(self.sigma_t_m).map(|value_m| SigmaT {
            value_m,
            std_m: self.sigma_t_std_m,
        })
    }

    /// Returns σ_t, m; NaN if no skin has it.
    pub fn sigma_t_m(&self) -> f64 {
        self.sigma_t().map_or(f64::NAN, |sigma_t| sigma_t.value_m)
    }

    /// Returns the standard error of σ_t, m; NaN if no skin has that σ_t.
    pub fn sigma_t_std_m(&self) -> f64 {
        self.sigma_t().map_or(f64::NAN, |sigma_t| sigma_t.std_m)
    }
}

/// Reasons why an instance has no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimateError {
    /// The instance cannot be fitted.
    #[error("`{}` cannot be fitted: {source}", method.name())]
    Fit {
        /// Method of the fit.
        method: Method,
        /// Reason.
        source: FitError,
    },
    /// The fit ended, but its parameters cannot be used.
    #[error("`{}` gave no usable fit: {verdict}", method.name())]
    Unusable {
        /// Method of the fit.
        method: Method,
        /// Verdict of the fit.
        verdict: FitVerdict,
    },
}

/// Estimates one instance of an exploration by `paper` and `dynamic`. Their verdicts state whether they can be
/// used: their assumed skin may be too wrong, although the fit of all instances together succeeds.
///
/// # Errors
/// Either method cannot be fitted.
pub fn estimate(
    (series, under_finger): (&FrameSeries, &UnderFinger),
    (exploration, direction): (usize, Direction),
    instance: Instance,
    (conditions, modal_mass_kg): (&FitConditions, f64),
    settings: &Settings,
) -> Result<(InstanceAnalysis, SampledInstance), EstimateError> {
    let span = (instance.start_s, instance.end_s);
    let samples = PreparedInstance::cut(series, under_finger, span);
    let fit_error = |method| move |source| EstimateError::Fit { method, source };
    let method_series = |method| samples.series(method).map_err(fit_error(method));
    let (paper_series, dynamic_series) = (
        method_series(Method::Paper)?,
        method_series(Method::Dynamic)?,
    );
    let (paper_options, dynamic_options) = (settings.paper(), settings.dynamic());
    let paper =
        paper::fit(&paper_series, conditions, &paper_options).map_err(fit_error(Method::Paper))?;
    let dynamic = dynamic::fit(&dynamic_series, conditions, &dynamic_options)
        .map_err(fit_error(Method::Dynamic))?;

    let measurement = MeasuredValues::new(&samples, conditions, modal_mass_kg);
    let rest = paper.rest;
    let (paper, sampled_paper) = measurement.estimate(
        Method::Paper,
        FittedValues {
            z_p: conditions.z_p_plain_n_s_per_m,
            z_m0: rest.z_m_plain_n_s_per_m,
            verdict: paper.verdict,
            sigma_t: (paper.sigma_t_m, paper.sigma_t_std_m),
            z_t: (paper.z_t_n_s_per_m, paper.z_t_std_n_s_per_m),
            tau_s: None,
            skin: conditions.assumed,
            plate_offset: None,
            mu0: (paper.mu0, paper.mu0_std),
            rest: Some(paper.rest),
            agreement: paper.agreement,
            misfit: paper.misfit,
            series: paper.series,
            sensitivities: paper::sensitivities(&paper_series, conditions, &paper_options).ok(),
        },
    );
    let finger = dynamic.finger;
    let misfit = dynamic::misfit(&dynamic_series, &dynamic);
    let sensitivities = dynamic::sensitivities(&dynamic_series, conditions, &dynamic_options).ok();
    let (lagged, sampled_dynamic) =
        measurement.lagged_estimate(dynamic, rest.z_m_corrected_n_s_per_m);
    let dynamic = InstanceEstimate {
        misfit,
        sensitivities,
        ..lagged
    };
    let edges = Edges::new(samples.time_s());
    let n = samples.time_s().len();
    let ratio = |k| samples.amplitude_ratio(Method::Dynamic, k);
    let analysis = InstanceAnalysis {
        exploration,
        direction,
        start_s: instance.start_s,
        end_s: instance.end_s,
        normal_n: samples.normal_n().iter().sum::<f64>() / samples.normal_n().len() as f64,
        delta_mu: edges.fall(|i| samples.mu()[i]),
        samples: n,
        mu: edges.means(|i| samples.mu()[i]),
        amplitude_at_crest_m: edges
            .means(|i| samples.amplitude_m(Method::Dynamic)[i])
            .last,
        amplitude_ratio: (0..n).map(ratio).sum::<f64>() / n as f64,
        paper,
        dynamic,
        trial: None,
        within_laws: None,
    };
    let sampled = SampledInstance {
        samples,
        finger,
        paper: sampled_paper,
        dynamic: sampled_dynamic,
        trial: None,
    };
    Ok((analysis, sampled))
}

/// Means over either end of an instance; NaN without a finite value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EdgeMeans {
    /// Mean over the first 5 ms.
    pub first: f64,
    /// Mean over the last 5 ms.
    pub last: f64,
}

/// First and last samples of an instance, for averages.
struct Edges {
    samples: usize,
    edge_samples: usize,
}

impl Edges {
    fn new(time_s: &[f64]) -> Self {
        let last_s = time_s.last().copied().unwrap_or_default();
        let samples = time_s.len();
        let edge_start = time_s.partition_point(|&t| t <= last_s - EDGE_S);
        Self {
            samples,
            edge_samples: samples - edge_start,
        }
    }

    /// Returns the mean of the first minus the mean of the last finite values; NaN without any.
    fn fall(&self, value: impl Fn(usize) -> f64) -> f64 {
        let means = self.means(value);
        means.first - means.last
    }

    fn means(&self, value: impl Fn(usize) -> f64) -> EdgeMeans {
        let mean = |range: std::ops::Range<usize>| {
            let finite_values: Vec<f64> = range.map(&value).filter(|v| v.is_finite()).collect();
            finite_values.iter().sum::<f64>() / finite_values.len() as f64
        };
        EdgeMeans {
            first: mean(0..self.edge_samples),
            last: mean(self.samples - self.edge_samples..self.samples),
        }
    }
}

/// Results common to both fits; values with their standard errors.
struct FittedValues {
    z_p: Complex64,
    z_m0: Complex64,
    verdict: FitVerdict,
    sigma_t: (f64, f64),
    z_t: (Complex64, Complex64),
    tau_s: Option<(f64, f64)>,
    skin: AssumedConstants,
    plate_offset: Option<PlateOffset>,
    mu0: (f64, f64),
    rest: Option<RestReading>,
    agreement: Agreement,
    misfit: Vec<InstanceMisfit>,
    series: EstimatedSeries,
    sensitivities: Option<Sensitivities>,
}

/// Measured values to compare with an estimate.
pub(crate) struct MeasuredValues<'a> {
    edges: Edges,
    conditions: &'a FitConditions,
    samples: &'a PreparedInstance,
    modal_mass_kg: f64,
}

impl<'a> MeasuredValues<'a> {
    pub(crate) fn new(
        samples: &'a PreparedInstance,
        conditions: &'a FitConditions,
        modal_mass_kg: f64,
    ) -> Self {
        Self {
            edges: Edges::new(samples.time_s()),
            conditions,
            samples,
            modal_mass_kg,
        }
    }

    /// Returns the estimate of `dynamic` or `trial`, with the corrected impedance `z_m0` at rest, without the signs of misfit and the
    /// sensitivities that only `dynamic` has.
    pub(crate) fn lagged_estimate(
        &self,
        fit: InstanceFit,
        z_m0: Complex64,
    ) -> (InstanceEstimate, EstimateSeries) {
        let plate_offset = self.plate_offset(&fit);
        self.estimate(
            Method::Dynamic,
            FittedValues {
                z_p: fit.finger.z_p_n_s_per_m(),
                z_m0,
                verdict: fit.verdict,
                sigma_t: (fit.sigma_t_m, fit.sigma_t_std_m),
                z_t: (fit.z_t_n_s_per_m, fit.z_t_std_n_s_per_m),
                tau_s: Some((fit.tau_s, fit.tau_std_s)),
                skin: *fit.finger.contact().assumed(),
                plate_offset: Some(plate_offset),
                mu0: (fit.mu0, fit.mu0_std),
                rest: None,
                agreement: fit.agreement,
                misfit: Vec::new(),
                series: fit.series,
                sensitivities: None,
            },
        )
    }

    /// Returns the estimates of `trial` with the laws as published taken as true.
    pub(crate) fn within_laws(&self, fit: &InstanceFit) -> WithinLaws {
        let offset = self.plate_offset(fit);
        let gap_m = &fit.series.gap_m;
        WithinLaws {
            sigma_t_m: LogUncertain {
                value: roughness(fit.sigma_t_m).unwrap_or(f64::NAN),
                ln_std: fit.sigma_t_std_m / fit.sigma_t_m,
            },
            z_t_n_s_per_m: fit.z_t_n_s_per_m,
            z_t_std_n_s_per_m: fit.z_t_std_n_s_per_m,
            mu0: Uncertain {
                value: fit.mu0,
                std: fit.mu0_std,
            },
            resonance_shift_hz: Uncertain {
                value: offset.resonance_shift_hz,
                std: offset.resonance_shift_std_hz,
            },
            mean_gap_m: gap_m.iter().sum::<f64>() / gap_m.len() as f64,
        }
    }

    fn plate_offset(&self, fit: &InstanceFit) -> PlateOffset {
        // With φ times the amplitude, the finger experiences 1/φ² of the plate's offset.
        let n = self.samples.time_s().len();
        let ratio = |k| self.samples.amplitude_ratio(Method::Dynamic, k).powi(2);
        let mean_square_ratio = (0..n).map(ratio).sum::<f64>() / n as f64;
        let offset = fit.plate_offset_n_s_per_m * mean_square_ratio;
        let offset_std = fit.plate_offset_std_n_s_per_m * mean_square_ratio;
        // Z_p at δω above its resonance is i 2 m δω.
        let hz_per_n_s_per_m = 1.0 / (2.0 * std::f64::consts::TAU * self.modal_mass_kg);
        PlateOffset {
            n_s_per_m: offset,
            std_n_s_per_m: offset_std,
            resonance_shift_hz: 0.0 - offset.im * hz_per_n_s_per_m,
            resonance_shift_std_hz: offset_std.im * hz_per_n_s_per_m,
        }
    }

    fn estimate(
        &self,
        method: Method,
        mut fit: FittedValues,
    ) -> (InstanceEstimate, EstimateSeries) {
        withhold_gap(&mut fit.series, fit.sigma_t.0);
        let (z_m, amplitude_m) = (self.samples.z_m(method), self.samples.amplitude_m(method));
        let assumed = &fit.skin;
        let gap_m = &fit.series.gap_m;
        let film_force_n: Vec<f64> = match Contact::new(assumed, fit.sigma_t.0) {
            Ok(contact) => gap_m
                .iter()
                .zip(amplitude_m)
                .map(|(&gap_m, &amplitude_m)| contact.squeeze_force_n(gap_m, amplitude_m))
                .collect(),
            Err(_) => vec![f64::NAN; gap_m.len()],
        };
        let impedances = Impedances {
            z_p_n_s_per_m: fit.z_p,
            z_t_n_s_per_m: fit.z_t.0,
            loss_factor: assumed.loss_factor,
            carrier_rad_per_s: std::f64::consts::TAU * self.conditions.carrier_hz,
        };
        let k_c = &fit.series.k_c_n_per_m;
        let motion = SkinMotion::new(&impedances, z_m, amplitude_m, k_c);
        let mut estimate = InstanceEstimate {
            spearman_mu: Coefficient::Spearman.correlate(&fit.series.mu, self.samples.mu()),
            deltas: Deltas {
                abs_z_m_n_s_per_m: self.edges.fall(|i| z_m[i].norm()),
                re_z_m_n_s_per_m: self.edges.fall(|i| z_m[i].re),
                abs_im_z_m_n_s_per_m: self.edges.fall(|i| z_m[i].im.abs()),
                gap_m: -self.edges.fall(|i| gap_m[i]),
                reaction_force_n: -self.edges.fall(|i| motion.reaction_force_n[i].norm()),
                squeeze_n: -self.edges.fall(|i| film_force_n[i]),
                mu: self.edges.fall(|i| fit.series.mu[i]),
            },
            z_p_n_s_per_m: fit.z_p,
            rigid_z_t_n_s_per_m: fit.z_m0 - fit.z_p,
            extents: Extents::default(),
            gap_at_crest_m: self.edges.means(|i| gap_m[i]).last,
            mu_at_rest: fit
                .rest
                .and_then(|rest| self.mu_at_rest(&rest, &fit.series.mu)),
            averaged: Averaged {
                sigma_t_m: f64::NAN,
                r2_impedance: f64::NAN,
            },
            verdict: fit.verdict,
            sigma_t_m: fit.sigma_t.0,
            sigma_t_std_m: fit.sigma_t.1,
            z_t_n_s_per_m: fit.z_t.0,
            z_t_std_n_s_per_m: fit.z_t.1,
            tau_s: fit.tau_s,
            skin: fit.skin,
            plate_offset: fit.plate_offset,
            mu0: fit.mu0.0,
            mu0_std: fit.mu0.1,
            rest: fit.rest,
            agreement: fit.agreement,
            misfit: fit.misfit,
            sensitivities: fit.sensitivities,
        };
        let series = EstimateSeries {
            contact: fit.series,
            motion,
            film_force_n,
        };
        estimate.extents = Extents::new(self.samples, method, &series);
        (estimate, series)
    }

    /// Returns the means of measured and estimated friction over the samples from which `paper` reads Z_m⁰; `None` without any.
    fn mu_at_rest(&self, rest: &RestReading, estimated_mu: &[f64]) -> Option<(f64, f64)> {
        let (mu, amplitude_m) = (self.samples.mu(), self.samples.amplitude_m(Method::Paper));
        let is_read =
            |k: &usize| amplitude_m[*k] <= rest.up_to_amplitude_m && estimated_mu[*k].is_finite();
        let read: Vec<usize> = (0..mu.len()).filter(is_read).collect();
        let n = read.len() as f64;
        let sum = read.iter().fold((0.0, 0.0), |sum, &k| {
            (sum.0 + mu[k], sum.1 + estimated_mu[k])
        });
        (n > 0.0).then(|| (sum.0 / n, sum.1 / n))
    }
}

/// Withholds the gap, and with it the film's force, of a fit that ended at a σ_t that no skin has: both follow from it.
fn withhold_gap(series: &mut EstimatedSeries, sigma_t_m: f64) {
    if roughness(sigma_t_m).is_err() {
        series.gap_m.fill(f64::NAN);
        series.gap_std_m.fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_roughness_that_no_skin_has_gives_no_gap() {
        let series = EstimatedSeries {
            time_s: vec![0.0],
            k_c_n_per_m: vec![1e5],
            k_c_std_n_per_m: vec![1e3],
            gap_m: vec![3e-6],
            gap_std_m: vec![1e-8],
            mu: vec![0.5],
            mu_std: vec![0.01],
            z_m_model_n_s_per_m: vec![Complex64::ZERO],
            inversion: contact::InversionCounts::default(),
        };
        let withheld = |sigma_t_m| {
            let mut series = series.clone();
            withhold_gap(&mut series, sigma_t_m);
            (series.gap_m[0].is_nan(), series.gap_std_m[0].is_nan())
        };
        assert_eq!(withheld(1.7e-6), (false, false));
        assert_eq!(withheld(0.3), (true, true));
    }

    #[test]
    fn a_fall_is_between_the_means_of_the_first_and_last_five_milliseconds() {
        let time_s: Vec<f64> = (0..121).map(|i| f64::from(i) * 5e-4).collect();
        let edges = Edges::new(&time_s);
        assert_eq!(edges.edge_samples, 10);
        assert_relative_eq!(edges.fall(|i| -(i as f64)), 111.0);
        assert_relative_eq!(edges.fall(|i| if i == 3 { f64::NAN } else { 7.0 }), 0.0);
    }
}
