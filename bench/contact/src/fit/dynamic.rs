//! The joint fit of σ_t, Re Z_t, Im Z_t and τ, with the effects that the published method leaves out.
//!
//! - The impedance is the envelope-corrected one.
//! - The gap follows its equilibrium (Huloux 2021, Eq. 17, with the momentary amplitude and normal force) as a
//!   first-order lag, τ dx/dt = x_eq − x, from 20 ms before the instance.
//! - k_c is Eq. 18 with the lagged gap and the momentary amplitude, so that the forces on the skin need not balance.
//! - The normal force is the cubic through the measured one: over 80 ms a finger's own force changes no faster, and a
//!   sensor's noise, 3 mN low-passed at 100 Hz, scatters σ_t by 1 %.
//! - Σ|Z_m,model − Z_m|² over the instance, complex, is minimised over all four parameters; τ ≥ 0.
//! - μ0 is the measured friction over the modelled ratio (Eq. 19), in least squares over the instance.
//!
//! Then k_c(t) by Eq. 12 from the measured impedance, the gap from k_c and amplitude, μ by Eq. 19.

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::estimated_series::{EstimatedSeries, FrictionAtRest, GapLaw, MeasuredSamples, estimate};
use super::fit_agreement::{Agreement, agreement};
use super::fit_error::FitError;
use super::fit_verdict::{FitParameter, FitVerdict, IDENTIFIABLE_RELATIVE_STD};
use super::lag::Lag;
use super::least_squares::{ImpedanceModel, Minimum, best_start, evaluated, minimise};
use super::modelled_series::ModelledSeries;
use super::sensitivity::{self, Sensitivities};
use super::series::{InstanceSamples, InstanceSeries, cubic_through, mean};
use super::sigma_search::sigma_starts;
use crate::contact::Contact;
use crate::finger::{FittedFinger, MS, Z_T_SLOPES};
use crate::harmonic::observed;
use crate::inversion::{Dependent, Inversion};

/// Options of the joint fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicOptions {
    /// How long before the instance the gap is integrated, s. Default 20 ms, some ten τ.
    pub lead_in_s: f64,
}

impl Default for DynamicOptions {
    fn default() -> Self {
        Self { lead_in_s: 0.02 }
    }
}

/// Result of the joint fit for one instance.
#[derive(Debug, Clone, PartialEq)]
pub struct DynamicFit {
    /// Whether the parameters may be used.
    pub verdict: FitVerdict,
    /// Roughness σ_t, m.
    pub sigma_t_m: f64,
    /// Standard error of `sigma_t_m`, m; infinite if not identifiable.
    pub sigma_t_std_m: f64,
    /// Tissue impedance Z_t, N·s/m.
    pub z_t_n_s_per_m: Complex64,
    /// Standard errors of the real and imaginary part of Z_t, N·s/m.
    pub z_t_std_n_s_per_m: Complex64,
    /// Levitation lag τ, s.
    pub tau_s: f64,
    /// Standard error of `tau_s`, s; 0 at the bound.
    pub tau_std_s: f64,
    /// Friction without vibration μ0.
    pub mu0: f64,
    /// Standard error of `mu0`.
    pub mu0_std: f64,
    /// Mean normal force ⟨f_c⟩ over the instance, N.
    pub normal_n: f64,
    /// How well fitted and measured agree.
    pub agreement: Agreement,
    /// Stiffness, gap and friction in time.
    pub series: EstimatedSeries,
    /// The fitted parameters with their covariance, for samples beyond this instance: [`crate::self_sensed`],
    /// [`crate::live_estimator`].
    pub finger: FittedFinger,
}

const N: usize = 4;
/// τ that starts are tried with, ms.
const TAU_STARTS_MS: [f64; 2] = [0.5, 2.0];
/// A standard error of τ beyond this is no identification, s: twice the lag that the bench is to resolve.
const IDENTIFIABLE_TAU_STD_S: f64 = 2e-3;

/// Fits σ_t, Z_t and τ to one instance.
///
/// # Errors
/// If the lead-in is too short, or no σ_t between 0.2 and 20 µm gives a contact that the model allows.
pub fn fit(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
) -> Result<DynamicFit, FitError> {
    let mut model = DynamicModel::new(instance, conditions, options)?;
    let solution = model.solve()?;
    model.report(&instance.instance(), solution)
}

/// Returns the model with a σ_t that was not fitted to this instance, such as a participant's average, and with `tau_s`; Z_t
/// and μ0 are those that then fit the instance best.
///
/// # Errors
/// If the lead-in is too short, or the model allows no such contact.
pub fn modelled(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
    sigma_t_m: f64,
    tau_s: f64,
) -> Result<ModelledSeries, FitError> {
    let mut model = DynamicModel::new(instance, conditions, options)?;
    let (ln_sigma_t, tau_ms) = (sigma_t_m.ln(), tau_s / MS);
    let contact = model.follow(ln_sigma_t, tau_ms).ok_or(FitError::NoStart)?;
    let z_t = model.tissue_given_gap(&contact);
    let z_m_n_s_per_m =
        evaluated(&mut model, &[ln_sigma_t, z_t.re, z_t.im, tau_ms]).ok_or(FitError::NoStart)?;
    let mu0 = model.friction_at_rest(&contact, instance.instance().mu).mu0;
    let from = model.lead;
    let gap_m = model.gap[from..].to_vec();
    let k_c = |(&gap_m, &a)| contact.stiffness_n_per_m(gap_m, a);
    let mu = |(&gap_m, &n)| mu0 * contact.friction_ratio(gap_m, n);
    Ok(ModelledSeries {
        z_m_n_s_per_m,
        k_c_n_per_m: gap_m
            .iter()
            .zip(&model.amplitude_m[from..])
            .map(k_c)
            .collect(),
        mu: gap_m.iter().zip(&model.normal_n[from..]).map(mu).collect(),
        gap_m,
    })
}

/// Returns how σ_t, Z_t and τ depend on the assumed constants.
///
/// # Errors
/// As [`fit`].
pub fn sensitivities(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
) -> Result<Sensitivities, FitError> {
    sensitivity::sensitivities(conditions, |conditions| {
        let solution = DynamicModel::new(instance, conditions, options)?.solve()?;
        let [ln_sigma_t, re, im, tau_ms] = solution.minimum.parameters;
        Ok((ln_sigma_t, Complex64::new(re, im), tau_ms * MS))
    })
}

struct JointSolution {
    minimum: Minimum<N>,
    /// Where τ would go, if the bound holds it.
    unbounded_tau_s: Option<f64>,
}

struct DynamicModel<'a> {
    conditions: &'a FitConditions,
    carrier_rad_per_s: f64,
    interval_s: f64,
    /// Amplitude, with `lead` samples before the instance, m.
    amplitude_m: &'a [f64],
    /// The cubic through the measured force.
    normal_n: Vec<f64>,
    lead: usize,
    /// Measured Z_m of the instance alone, N·s/m.
    z_m: &'a [Complex64],
    equilibrium: Vec<f64>,
    equilibrium_slope: Vec<f64>,
    gap: Vec<f64>,
    gap_by_sigma: Vec<f64>,
    gap_by_tau: Vec<f64>,
}

impl<'a> DynamicModel<'a> {
    fn new(
        instance: &InstanceSeries<'a>,
        conditions: &'a FitConditions,
        options: &DynamicOptions,
    ) -> Result<Self, FitError> {
        conditions.assumed.validated()?;
        let (samples, lead) = instance.with_lead_in(options.lead_in_s)?;
        let n = samples.time_s.len();
        Ok(Self {
            conditions,
            carrier_rad_per_s: conditions.carrier_rad_per_s()?,
            interval_s: instance.interval_s(),
            amplitude_m: samples.amplitude_m,
            normal_n: cubic_through(samples.normal_n),
            lead,
            z_m: &samples.z_m_corrected_n_s_per_m[lead..],
            equilibrium: vec![0.0; n],
            equilibrium_slope: vec![0.0; n],
            gap: vec![0.0; n],
            gap_by_sigma: vec![0.0; n],
            gap_by_tau: vec![0.0; n],
        })
    }

    /// Gap and its slopes at ln σ_t and τ, with the contact.
    fn follow(&mut self, ln_sigma_t: f64, tau_ms: f64) -> Option<Contact> {
        let contact = Contact::new(&self.conditions.assumed, ln_sigma_t.exp()).ok()?;
        contact
            .equilibrium_gaps_m(self.amplitude_m, &self.normal_n, &mut self.equilibrium)
            .ok()?;
        for ((slope, &gap), &normal_n) in self
            .equilibrium_slope
            .iter_mut()
            .zip(&self.equilibrium)
            .zip(&self.normal_n)
        {
            *slope = contact.equilibrium_gap_slope(gap, normal_n);
        }
        let lag = Lag::new(tau_ms * MS, self.interval_s);
        lag.apply(&self.equilibrium, &mut self.gap);
        lag.apply(&self.equilibrium_slope, &mut self.gap_by_sigma);
        lag.slope(&self.equilibrium, &self.gap, &mut self.gap_by_tau);
        self.gap.iter().all(|gap| *gap > 0.0).then_some(contact)
    }

    /// Given σ_t and τ, 1/(Z_m − Z_p) = 1/Z_t + 1/Z_c is linear in 1/Z_t: its mean, weighted as the impedance residual
    /// weighs it.
    fn tissue_given_gap(&self, contact: &Contact) -> Complex64 {
        let (mut sum, mut weights) = (Complex64::ZERO, 0.0);
        let film = self.gap[self.lead..]
            .iter()
            .zip(&self.amplitude_m[self.lead..]);
        for (&z_m, (&gap, &amplitude)) in self.z_m.iter().zip(film) {
            let finger = z_m - self.conditions.z_p_corrected_n_s_per_m;
            let z_c = contact.impedance_n_s_per_m(
                contact.stiffness_n_per_m(gap, amplitude),
                self.carrier_rad_per_s,
            );
            let weight = finger.norm_sqr().powi(2);
            if weight > 0.0 {
                sum += weight * (finger.inv() - z_c.inv());
                weights += weight;
            }
        }
        weights / sum
    }

    fn start(&mut self, tau_ms: f64) -> Option<[f64; N]> {
        let candidates: Vec<[f64; N]> = sigma_starts()
            .filter_map(|sigma| {
                let contact = self.follow(sigma.ln(), tau_ms)?;
                let z_t = self.tissue_given_gap(&contact);
                Some([sigma.ln(), z_t.re, z_t.im, tau_ms])
            })
            .collect();
        best_start(self, candidates)
    }

    fn solve(&mut self) -> Result<JointSolution, FitError> {
        let starts: Vec<[f64; N]> = TAU_STARTS_MS
            .iter()
            .filter_map(|&tau_ms| self.start(tau_ms))
            .collect();
        let mut solutions: Vec<JointSolution> = Vec::with_capacity(starts.len());
        for start in starts {
            let free = minimise(self, start);
            let [ln_sigma_t, re, im, tau_ms] = free.parameters;
            solutions.push(if tau_ms >= 0.0 {
                JointSolution {
                    minimum: free,
                    unbounded_tau_s: None,
                }
            } else {
                let bound = minimise(&mut WithoutLag(self), [ln_sigma_t, re, im]);
                JointSolution {
                    minimum: bound.extended(0.0),
                    unbounded_tau_s: Some(tau_ms * MS),
                }
            });
        }
        solutions
            .into_iter()
            .min_by(|a, b| {
                let (a, b) = (&a.minimum, &b.minimum);
                a.failure
                    .is_some()
                    .cmp(&b.failure.is_some())
                    .then(a.squares.total_cmp(&b.squares))
            })
            .ok_or(FitError::NoStart)
    }

    fn report(
        &mut self,
        samples: &InstanceSamples<'_>,
        solution: JointSolution,
    ) -> Result<DynamicFit, FitError> {
        let JointSolution {
            minimum,
            unbounded_tau_s,
        } = solution;
        let [ln_sigma_t, re, im, tau_ms] = minimum.parameters;
        let z_t = Complex64::new(re, im);
        let std = |i: usize| minimum.std(i);
        let verdict = self.verdict(&minimum, unbounded_tau_s);
        let contact = self.follow(ln_sigma_t, tau_ms).ok_or(FitError::NoStart)?;
        let friction = self.friction_at_rest(&contact, samples.mu);
        let z_m_std: Vec<f64> = samples
            .amplitude_m
            .iter()
            .map(|a| minimum.noise.std(a.recip()))
            .collect();
        let finger = FittedFinger {
            inversion: Inversion {
                contact,
                carrier_rad_per_s: self.carrier_rad_per_s,
                z_p: self.conditions.z_p_corrected_n_s_per_m,
                z_t,
                z_t_slopes: Z_T_SLOPES,
                covariance: minimum.covariance,
            },
            tau_s: tau_ms * MS,
            z_m_noise: minimum.noise,
        };
        let mu0_std = finger.inversion.std(&Dependent {
            value: friction.mu0,
            slopes: friction.slopes.into(),
            noise: friction.std,
        });
        let measured = MeasuredSamples {
            time_s: samples.time_s,
            z_m: self.z_m,
            z_m_std: &z_m_std,
            amplitude_m: samples.amplitude_m,
            normal_n: &self.normal_n[self.lead..],
        };
        let (sigma_t_std_m, z_t_std, tau_std_s) = (
            contact.sigma_t_m() * std(0),
            Complex64::new(std(1), std(2)),
            std(3) * MS,
        );
        let series = estimate(
            &finger.inversion,
            GapLaw::Amplitude,
            &friction,
            &measured,
            minimum.z_m,
        );
        Ok(DynamicFit {
            verdict,
            sigma_t_m: contact.sigma_t_m(),
            sigma_t_std_m,
            z_t_n_s_per_m: z_t,
            z_t_std_n_s_per_m: z_t_std,
            tau_s: tau_ms * MS,
            tau_std_s,
            mu0: friction.mu0,
            mu0_std,
            normal_n: mean(samples.normal_n),
            agreement: agreement(self.z_m, samples.mu, &series),
            series,
            finger,
        })
    }

    fn verdict(&self, minimum: &Minimum<N>, unbounded_tau_s: Option<f64>) -> FitVerdict {
        if let Some(reason) = &minimum.failure {
            return FitVerdict::NotConverged {
                reason: reason.clone(),
            };
        }
        let std = |i: usize| minimum.std(i);
        let [_, re, im, _] = minimum.parameters;
        let weak = [
            (FitParameter::SigmaT, std(0), IDENTIFIABLE_RELATIVE_STD),
            (
                FitParameter::ZT,
                std(1).hypot(std(2)) / re.hypot(im),
                IDENTIFIABLE_RELATIVE_STD,
            ),
            (FitParameter::Tau, std(3) * MS, IDENTIFIABLE_TAU_STD_S),
        ];
        let worst = weak
            .into_iter()
            .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)));
        match (worst, unbounded_tau_s) {
            (Some((parameter, std, limit)), _) if std > limit || std.is_nan() => {
                FitVerdict::NotIdentifiable { parameter, std }
            }
            (_, Some(unbounded_tau_s)) => FitVerdict::LagAtBound { unbounded_tau_s },
            _ => FitVerdict::Converged,
        }
    }

    /// μ0 = Σ m μ/Σ m² with m the modelled μ/μ0, after [`follow`](Self::follow).
    fn friction_at_rest(&self, contact: &Contact, mu: &[f64]) -> FrictionAtRest<N> {
        let sigma = contact.sigma_t_m();
        let ratios: Vec<f64> = self
            .gap
            .iter()
            .zip(&self.normal_n)
            .map(|(&x, &n)| contact.friction_ratio(x, n))
            .skip(self.lead)
            .collect();
        let power: f64 = ratios.iter().map(|m| m * m).sum();
        let mu0 = ratios.iter().zip(mu).map(|(m, mu)| m * mu).sum::<f64>() / power;
        let mut slopes = [0.0; N];
        let mut squares = 0.0;
        for (i, (&ratio, &mu)) in ratios.iter().zip(mu).enumerate() {
            let gap = self.gap[self.lead + i];
            let by_ln_sigma = ratio * (1.0 + gap / sigma - self.gap_by_sigma[self.lead + i]);
            let by_tau_ms = -ratio / sigma * self.gap_by_tau[self.lead + i] * MS / self.interval_s;
            let weight = (mu - 2.0 * mu0 * ratio) / power;
            slopes[0] += weight * by_ln_sigma;
            slopes[3] += weight * by_tau_ms;
            squares += (mu - mu0 * ratio).powi(2);
        }
        let freedom = (ratios.len() - 1) as f64;
        FrictionAtRest {
            mu0,
            slopes,
            std: (squares / freedom / power).sqrt(),
        }
    }
}

impl ImpedanceModel<N> for DynamicModel<'_> {
    fn measured(&self) -> &[Complex64] {
        self.z_m
    }

    /// White noise on force and velocity is noise on their ratio that grows as 1/|ṽ_p|.
    fn noise_shape(&self, index: usize) -> f64 {
        self.amplitude_m[self.lead + index].recip()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64; N],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; N]],
    ) -> Option<()> {
        let [ln_sigma_t, re, im, tau_ms] = *parameters;
        let contact = self.follow(ln_sigma_t, tau_ms)?;
        let sigma = contact.sigma_t_m();
        let z_t = Complex64::new(re, im);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for index in 0..z_m.len() {
            let at = self.lead + index;
            let (gap, amplitude) = (self.gap[at], self.amplitude_m[at]);
            let by_gap = contact.stiffness_slope_n_per_m2(gap, amplitude);
            let by_ln_sigma =
                contact.stiffness_by_ln_sigma_n_per_m(gap) + by_gap * self.gap_by_sigma[at] * sigma;
            let by_tau_ms = by_gap * self.gap_by_tau[at] * MS / self.interval_s;
            let z_c = z_c_per_stiffness * contact.stiffness_n_per_m(gap, amplitude);
            let both = z_t + z_c;
            let by_stiffness = (z_t / both).powi(2) * z_c_per_stiffness;
            let by_z_t = (z_c / both).powi(2);
            z_m[index] = observed(self.conditions.z_p_corrected_n_s_per_m, z_t, z_c);
            slopes[index] = [
                by_stiffness * by_ln_sigma,
                by_z_t,
                by_z_t * Complex64::I,
                by_stiffness * by_tau_ms,
            ];
        }
        Some(())
    }
}

/// The model with τ at its bound, 0.
struct WithoutLag<'m, 'a>(&'m mut DynamicModel<'a>);

impl ImpedanceModel<3> for WithoutLag<'_, '_> {
    fn measured(&self) -> &[Complex64] {
        self.0.z_m
    }

    fn noise_shape(&self, index: usize) -> f64 {
        self.0.noise_shape(index)
    }

    fn evaluate(
        &mut self,
        &[ln_sigma_t, re, im]: &[f64; 3],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; 3]],
    ) -> Option<()> {
        let mut all = vec![[Complex64::ZERO; N]; slopes.len()];
        self.0.evaluate(&[ln_sigma_t, re, im, 0.0], z_m, &mut all)?;
        for (slope, [sigma, by_re, by_im, _]) in slopes.iter_mut().zip(all) {
            *slope = [sigma, by_re, by_im];
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::least_squares::tests::assert_slopes_are_derivatives;
    use crate::fit::series::tests::with_instance;

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model =
                DynamicModel::new(instance, &conditions, &DynamicOptions::default()).unwrap();
            for tau_ms in [-0.2, 0.05, 1.2] {
                assert_slopes_are_derivatives(&mut model, [1.7e-6_f64.ln(), 0.47, 3.16, tau_ms]);
            }
            assert_slopes_are_derivatives(&mut WithoutLag(&mut model), [2.5e-6_f64.ln(), 0.2, 2.0]);
        });
    }
}
