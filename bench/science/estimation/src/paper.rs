//! The published method: a fit of σ_t alone.
//!
//! Per instance: Z_m⁰ is the mean measured impedance where the instance's amplitude is below 0.2 µm, or in its lowest 5
//! ms. μ0, the friction without vibration, is the mean measured friction where the amplitude is below 0.2 µm in the whole
//! rise around the instance (docs/decisions/0008). For any σ_t the stiffness at rest is k_c⁰ = ⟨f_c⟩/σ_t with ⟨f_c⟩ the mean
//! normal force; Z_t follows by Eq. 21, the gap at each instant by Eq. 17, k_c by Eq. 18 and Z_m by Eq. 9.
//! σ_t minimises Σ|Z_m,model − Z_m|² over the instance, complex. Then follow k_c(t) by Eq. 12, the gap by Eq. 18 and μ by
//! Eq. 19. The method treats every instant as a steady state, and the amplitude where Z_t is read as rest. This biases σ_t
//! upwards and Z_t downwards; the bias is part of the method.
//!
//! The unknown is ln σ_t alone; the data are the n plain impedances. All of these are functions of ln σ_t, with x the root of
//! Eq. 17:
//!
//! ```text
//! Z_t = F Z_c⁰/(Z_c⁰ − F),  F = Z_m⁰ − Z_p,  Z_c⁰ = (η − i) ⟨f_c⟩/(ω σ_t)                   (21)
//! k_c = f_r/σ_t + 2 (⟨f_c⟩ − f_r)/x,  f_r = p_c S e^(−x/σ_t),  Z_c = (η − i) k_c/ω          (18)
//! Z_m = Z_p + Z_t Z_c/(Z_t + Z_c)                                                          (9)
//! ```
//!
//! Least squares is maximum likelihood for independent normal errors of one variance. Levenberg–Marquardt starts from the best
//! σ_t of a grid.

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::estimated_series::{EstimatedSeries, GapLaw, MeasuredSamples, estimate};
use super::fit_agreement::{Agreement, agreement};
use super::fit_error::FitError;
use super::fit_verdict::{FitParameter, FitVerdict, StandardError, find_unidentified};
use super::friction_law::FrictionLaw;
use super::instance_misfit::{InstanceMisfit, Judged, Limits};
use super::least_squares::{ImpedanceModel, Minimum, best_start, minimise, model_impedances};
use super::modelled_series::ModelledSeries;
use super::sensitivity::{self, Refit, Sensitivities};
use super::series::{InstanceSamples, InstanceSeries, mean};
use super::sigma_search::sigma_starts;
use contact::Contact;
use contact::calibration_errors::ByError;
use contact::harmonic::{contact_impedance, observed, tissue_from_observed};
use contact::inversion::Inversion;
use contact::parameters::LoadSlopes;
use serde::{Deserialize, Serialize};

/// Options of the published method: where to read the tissue impedance and μ0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperOptions {
    /// Amplitudes below this count as rest, m. Default 0.2 µm (Huloux 2021; elsewhere it says 2 µm).
    pub rest_amplitude_m: f64,
    /// Duration of the lowest amplitudes, used in an instance that never goes below the threshold, s. Default 5 ms.
    pub lowest_s: f64,
}

impl Default for PaperOptions {
    fn default() -> Self {
        Self {
            rest_amplitude_m: 0.2e-6,
            lowest_s: 5e-3,
        }
    }
}

/// Samples from which Z_m⁰ was read, and μ0 too if the whole rise never goes below the threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RestReading {
    /// Whether the instance goes below [`PaperOptions::rest_amplitude_m`]; if not, its lowest amplitudes are used.
    pub below_threshold: bool,
    /// Number of samples used.
    pub samples: usize,
    /// Largest amplitude among the samples used, m.
    pub up_to_amplitude_m: f64,
    /// Z_m⁰, their mean plain impedance, N·s/m.
    pub z_m_plain_n_s_per_m: Complex64,
    /// Their mean corrected impedance, N·s/m.
    pub z_m_corrected_n_s_per_m: Complex64,
}

/// Result of the published method for one instance.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFit {
    /// Whether the parameters may be used.
    pub verdict: FitVerdict,
    /// Roughness σ_t, m.
    pub sigma_t_m: f64,
    /// Standard error of `sigma_t_m`, m; infinite if not identifiable.
    pub sigma_t_std_m: f64,
    /// Tissue impedance Z_t by Eq. 21, N·s/m.
    pub z_t_n_s_per_m: Complex64,
    /// Standard errors of the real and imaginary part of Z_t, N·s/m.
    pub z_t_std_n_s_per_m: Complex64,
    /// Friction without vibration μ0.
    pub mu0: f64,
    /// Standard error of `mu0`.
    pub mu0_std: f64,
    /// Mean normal force ⟨f_c⟩ over the instance, N.
    pub normal_n: f64,
    /// Samples from which Z_m⁰ was read.
    pub rest: RestReading,
    /// Agreement of fit and measurement.
    pub agreement: Agreement,
    /// Stiffness, gap and friction over time.
    pub series: EstimatedSeries,
    /// Signs that the instance does not follow the method's laws.
    pub misfit: Vec<InstanceMisfit>,
}

/// Largest RMS of estimated − measured friction, relative to μ0.
const MAX_RMS_PART: f64 = 0.45;

/// Fits σ_t to one instance.
///
/// # Errors
/// If no σ_t between 0.2 and 20 µm gives a contact that the model allows.
pub fn fit(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &PaperOptions,
) -> Result<PaperFit, FitError> {
    let samples = instance.instance();
    let rest = InstanceRest::read(instance, options);
    let mut model = PaperModel::new(&samples, conditions, rest.reading.z_m_plain_n_s_per_m)?;
    let minimum = model.minimise()?;
    model.report(&samples, minimum, &rest)
}

/// Returns the model with a σ_t that was not fitted to this instance, such as a participant's average; Z_t (Eq. 21) and μ0
/// are those of the instance.
///
/// # Errors
/// If the model allows no such contact.
pub fn model_series(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &PaperOptions,
    sigma_t_m: f64,
) -> Result<ModelledSeries, FitError> {
    let samples = instance.instance();
    let rest = InstanceRest::read(instance, options);
    let mut model = PaperModel::new(&samples, conditions, rest.reading.z_m_plain_n_s_per_m)?;
    let z_m_n_s_per_m = model_impedances(&mut model, &[sigma_t_m.ln()]).ok_or(FitError::NoStart)?;
    let contact = Contact::new(&conditions.assumed, sigma_t_m)?;
    let mu0 = rest.friction.mu0;
    let film = || model.gap_m.iter().zip(&model.normal_n);
    Ok(ModelledSeries {
        z_m_n_s_per_m,
        k_c_n_per_m: film()
            .map(|(&gap_m, &n)| contact.balance_stiffness_n_per_m(gap_m, n))
            .collect(),
        mu: film()
            .map(|(&gap_m, &n)| mu0 * contact.friction_ratio(gap_m, n))
            .collect(),
        gap_m: model.gap_m,
    })
}

/// Returns how σ_t and Z_t depend on the assumed constants.
///
/// # Errors
/// Same as [`fit`].
pub fn sensitivities(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &PaperOptions,
) -> Result<Sensitivities, FitError> {
    sensitivity::sensitivities(conditions, |conditions| {
        let samples = instance.instance();
        let rest = InstanceRest::read(instance, options);
        let mut model = PaperModel::new(&samples, conditions, rest.reading.z_m_plain_n_s_per_m)?;
        let minimum = model.minimise()?;
        let [ln_sigma_t] = minimum.parameters;
        Ok(Refit {
            ln_sigma_t,
            z_t: model.tissue(ln_sigma_t).0,
            tau_s: 0.0,
        })
    })
}

struct InstanceRest {
    friction: FrictionLaw<1>,
    reading: RestReading,
}

impl InstanceRest {
    fn read(instance: &InstanceSeries<'_>, options: &PaperOptions) -> Self {
        let samples = instance.instance();
        let amplitude = samples.amplitude_m;
        let mut indices: Vec<usize> = (0..amplitude.len())
            .filter(|&i| amplitude[i] < options.rest_amplitude_m)
            .collect();
        let has_rest = !indices.is_empty();
        if !has_rest {
            indices = (0..amplitude.len()).collect();
            indices.sort_by(|&a, &b| amplitude[a].total_cmp(&amplitude[b]));
            let lowest = (options.lowest_s / instance.interval_s()).round() as usize;
            indices.truncate(lowest.max(1));
        }
        let mean_impedance = |z_m: &[Complex64]| {
            indices.iter().map(|&i| z_m[i]).sum::<Complex64>() / indices.len() as f64
        };
        let rise = instance.rise();
        let mut mu: Vec<f64> = rise
            .amplitude_m
            .iter()
            .zip(rise.mu)
            .filter(|(a, mu)| **a < options.rest_amplitude_m && mu.is_finite())
            .map(|(_, mu)| *mu)
            .collect();
        if mu.is_empty() {
            mu = indices.iter().map(|&i| samples.mu[i]).collect();
        }
        let n = mu.len() as f64;
        let mu0 = mean(&mu);
        let scatter = mu.iter().map(|m| (m - mu0).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        Self {
            friction: FrictionLaw::paper(mu0, (scatter / n).sqrt(), [0.0]),
            reading: RestReading {
                below_threshold: has_rest,
                samples: indices.len(),
                up_to_amplitude_m: indices.iter().map(|&i| amplitude[i]).fold(0.0, f64::max),
                z_m_plain_n_s_per_m: mean_impedance(samples.z_m_plain_n_s_per_m),
                z_m_corrected_n_s_per_m: mean_impedance(samples.z_m_corrected_n_s_per_m),
            },
        }
    }
}

struct PaperModel<'a> {
    conditions: &'a FitConditions,
    carrier_rad_per_s: f64,
    z_m: &'a [Complex64],
    amplitude_m: &'a [f64],
    normal_n: Vec<f64>,
    /// Z_m⁰ − Z_p.
    finger_at_rest: Complex64,
    gap_m: Vec<f64>,
}

impl<'a> PaperModel<'a> {
    fn new(
        samples: &InstanceSamples<'a>,
        conditions: &'a FitConditions,
        z_m_rest: Complex64,
    ) -> Result<Self, FitError> {
        conditions.assumed.validated()?;
        let n = samples.time_s.len();
        Ok(Self {
            conditions,
            carrier_rad_per_s: conditions.carrier_rad_per_s()?,
            z_m: samples.z_m_plain_n_s_per_m,
            amplitude_m: samples.amplitude_m,
            normal_n: vec![mean(samples.normal_n); n],
            finger_at_rest: z_m_rest - conditions.z_p_plain_n_s_per_m,
            gap_m: vec![0.0; n],
        })
    }

    /// Returns Z_t by Eq. 21 and its derivative by ln σ_t.
    fn tissue(&self, ln_sigma_t: f64) -> (Complex64, Complex64) {
        let k_c0 = self.normal_n[0] / ln_sigma_t.exp();
        let z_c0 = contact_impedance(
            k_c0,
            self.conditions.assumed.loss_factor,
            self.carrier_rad_per_s,
        );
        let finger = self.finger_at_rest;
        // ∂Z_t/∂Z_c⁰ = ((Z_c⁰ − F) F − F Z_c⁰)/(Z_c⁰ − F)² = −F²/(Z_c⁰ − F)², and k_c⁰ = ⟨f_c⟩/σ_t: ∂Z_c⁰/∂ ln σ_t = −Z_c⁰.
        let by_z_c0 = -(finger / (z_c0 - finger)).powi(2);
        (
            tissue_from_observed(finger, Complex64::ZERO, z_c0),
            by_z_c0 * -z_c0,
        )
    }

    fn minimise(&mut self) -> Result<Minimum<1>, FitError> {
        let start =
            best_start(self, sigma_starts().map(|sigma| [sigma.ln()])).ok_or(FitError::NoStart)?;
        Ok(minimise(self, start, &[0], &ByError::zeros()))
    }

    fn report(
        &self,
        samples: &InstanceSamples<'_>,
        minimum: Minimum<1>,
        rest: &InstanceRest,
    ) -> Result<PaperFit, FitError> {
        let sigma_t_m = minimum.parameters[0].exp();
        let (z_t, z_t_slope) = self.tissue(minimum.parameters[0]);
        let ln_std = minimum.std(0);
        let verdict = if let Some(reason) = minimum.failure {
            FitVerdict::NotConverged { reason }
        } else {
            let error = StandardError::relative(FitParameter::SigmaT, ln_std);
            find_unidentified([error]).unwrap_or(FitVerdict::Converged)
        };
        let inversion = Inversion {
            contact: Contact::new(&self.conditions.assumed, sigma_t_m)?,
            carrier_rad_per_s: self.carrier_rad_per_s,
            z_p: self.conditions.z_p_plain_n_s_per_m,
            z_t,
            z_t_slopes: [z_t_slope],
            z_p_slopes: [Complex64::ZERO],
            finger_scale: Complex64::ONE,
            finger_slopes: [Complex64::ZERO],
            residual_mobility: Complex64::ZERO,
            residual_slopes: [Complex64::ZERO],
            load: LoadSlopes::default(),
            covariance: minimum.covariance,
        };
        let measurement = MeasuredSamples {
            time_s: samples.time_s,
            z_m: self.z_m,
            z_m_std: &vec![minimum.noise.std(1.0); self.z_m.len()],
            amplitude_m: self.amplitude_m,
            normal_n: &self.normal_n,
            load_trend: None,
        };
        let series = estimate(
            &inversion,
            GapLaw::Balance,
            &rest.friction,
            &measurement,
            minimum.z_m,
        );
        let agreement = agreement(self.z_m, samples.mu, &series, &series.mu);
        let limits = Limits {
            sigma_t_m: [0.5e-6, 5e-6],
            re_z_t_n_s_per_m: f64::NEG_INFINITY,
            residual_part: 0.6,
            rms_mu: MAX_RMS_PART * rest.friction.mu0,
        };
        let re_z_t_std = z_t_slope.re.abs() * ln_std;
        let misfit = limits.signs(&Judged {
            sigma_t_m,
            re_z_t_n_s_per_m: [z_t.re, re_z_t_std],
            agreement: &agreement,
            z_m: self.z_m,
            z_m_model: &series.z_m_model_n_s_per_m,
        });
        Ok(PaperFit {
            verdict,
            sigma_t_m,
            sigma_t_std_m: sigma_t_m * ln_std,
            z_t_n_s_per_m: z_t,
            z_t_std_n_s_per_m: Complex64::new(re_z_t_std, z_t_slope.im.abs() * ln_std),
            mu0: rest.friction.mu0,
            mu0_std: rest.friction.mu0_scatter(),
            normal_n: self.normal_n[0],
            rest: rest.reading,
            agreement,
            series,
            misfit,
        })
    }
}

impl ImpedanceModel<1> for PaperModel<'_> {
    fn measurement(&self) -> &[Complex64] {
        self.z_m
    }

    fn noise_shape(&self, _index: usize) -> f64 {
        1.0
    }

    fn evaluate(
        &mut self,
        &[ln_sigma_t]: &[f64; 1],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; 1]],
    ) -> Option<()> {
        let sigma = ln_sigma_t.exp();
        let contact = Contact::new(&self.conditions.assumed, sigma).ok()?;
        contact
            .equilibrium_gaps_m(self.amplitude_m, &self.normal_n, &mut self.gap_m)
            .ok()?;
        let (z_t, z_t_slope) = self.tissue(ln_sigma_t);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        let normal_n = self.normal_n[0];
        for (index, &gap) in self.gap_m.iter().enumerate() {
            let k_c = contact.balance_stiffness_n_per_m(gap, normal_n);
            // dk_c/d ln σ_t = ∂k_c/∂ ln σ_t + (∂k_c/∂x) ∂x/∂ ln σ_t, x the root of Eq. 17.
            // dZ_m/d ln σ_t = (Z_t/(Z_t + Z_c))² (η − i)/ω dk_c/d ln σ_t + (Z_c/(Z_t + Z_c))² dZ_t/d ln σ_t.
            let by_ln_sigma = contact
                .balance_stiffness_slopes_n_per_m(gap, normal_n)
                .by_ln_sigma_t
                + contact.balance_stiffness_slope_n_per_m2(gap, normal_n)
                    * contact
                        .equilibrium_gap_slopes_m(gap, normal_n)
                        .by_ln_sigma_t;
            let z_c = z_c_per_stiffness * k_c;
            let z_sum = z_t + z_c;
            z_m[index] = observed(self.conditions.z_p_plain_n_s_per_m, z_t, z_c);
            slopes[index] = [(z_t / z_sum).powi(2) * z_c_per_stiffness * by_ln_sigma
                + (z_c / z_sum).powi(2) * z_t_slope];
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::tests::assert_slopes_are_derivatives;
    use crate::series::tests::with_instance;

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model =
                PaperModel::new(&instance.instance(), &conditions, Complex64::new(9.5, -2.0))
                    .unwrap();
            for sigma_t_m in [0.8e-6_f64, 1.7e-6, 5e-6] {
                assert_slopes_are_derivatives(&mut model, [sigma_t_m.ln()]);
            }
        });
    }
}
