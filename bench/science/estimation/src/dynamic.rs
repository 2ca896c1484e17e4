//! The joint fit of σ_t, Re Z_t, Im Z_t, τ and the plate's offset, with the effects that the published method neglects.
//!
//! - The impedance is the envelope-corrected one. For slowly varying envelopes f̃_a = Z(ω) ṽ_p − i Z′(ω) dṽ_p/dt, and near the
//!   resonance Z′ = i (m_p + k_p/ω²) ≈ 2i m_p, so Z_m = (f̃_a − 2 m_p dṽ_p/dt)/ṽ_p.
//! - The gap follows its equilibrium (Huloux 2021, Eq. 17, with the momentary amplitude and normal force) as a
//!   first-order lag, τ dx/dt = x_eq − x, from 20 ms before the instance.
//! - k_c is Eq. 18 with the lagged gap and the momentary amplitude, so that the forces on the skin need not balance.
//! - The normal force is used as given, tremor included: smoothing the finger's force biases σ_t and τ, and so does noise of
//!   the sensor. The caller separates the two.
//! - Σ|Z_m,model − Z_m|² over the instance, complex, is minimised over all parameters; τ ≥ 0.
//! - The plate's impedance may have changed since the unloaded reading: i·y is added to Z_p and y is fitted. The crest of the
//!   modulation, where the finger is nearly released, determines y. A resonance shifted by δf adds −i·4π m_p δf: with
//!   k_p = (2π f0)² m_p, ∂(k_p/(iω))/∂f0 = −i·8π² f0 m_p/ω, and ω ≈ 2π f0.
//! - μ0 is the least-squares ratio of measured friction to the modelled μ/μ0 (Eq. 19) over the instance.
//!
//! Then follow k_c(t) by Eq. 12 from the measured impedance, the gap from k_c and amplitude, and μ by Eq. 19.
//!
//! Unknowns are θ = (ln σ_t, Re Z_t, Im Z_t, τ, y); S, q0, E, ν and η are assumed. Data are the n complex values Z_m of the
//! instance; amplitude and force are taken as exact. If both parts of every residual r = Z_m,model(θ) − Z_m are independent and
//! normal with one variance σ², −2 ln L = Σ|r|²/σ² + 4n ln σ + const, and least squares is maximum likelihood; standard errors
//! do not assume it (`least_squares.rs`). For τ = 0.5 and 2 ms a grid of σ_t, each with its best Z_t in closed form, gives two
//! starts, y = 0 and y fitted; Levenberg–Marquardt descends from each. Where it ends at τ < 0 it is repeated with τ = 0. The
//! smallest Σ|r|² of those that converged is the estimate.

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::fit_verdict::{FitParameter, FitVerdict, StandardError, find_unidentified};
use super::instance_fit::{InstanceFit, friction_at_rest};
use super::instance_misfit::{InstanceMisfit, Judged, Limits};
use super::lagged_model::{LaggedModel, Laws};
use super::least_squares::{Minimum, minimise, model_impedances};
use super::modelled_series::ModelledSeries;
use super::sensitivity::{self, Refit, Sensitivities};
use super::series::{InstanceSeries, mean};
use super::sigma_search::sigma_starts;
use contact::parameters::{IM_OFFSET, IM_Z_T, LN_SIGMA_T, MS, PARAMETERS, RE_Z_T, TAU_MS};

/// Options of the joint fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicOptions {
    /// Time before the instance from which the gap is integrated, s. Default 20 ms, some ten τ.
    pub lead_in_s: f64,
    /// Whether the plate's offset is fitted. Default true; otherwise the plate is taken as unloaded.
    pub plate_offset: bool,
}

impl Default for DynamicOptions {
    fn default() -> Self {
        Self {
            lead_in_s: 0.02,
            plate_offset: true,
        }
    }
}

/// Starting values of τ, s.
const TAU_STARTS_S: [f64; 2] = [0.5e-3, 2e-3];
/// Standard error of τ above which it is not identified, s: twice the lag that the bench must resolve.
const IDENTIFIABLE_TAU_STD_S: f64 = 2e-3;

/// Fits σ_t, Z_t, τ and the plate's offset to one instance.
///
/// # Errors
/// If the lead-in is too short, or no σ_t between 0.2 and 20 µm gives a contact that the model allows.
pub fn fit(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
) -> Result<InstanceFit, FitError> {
    let mut model = lagged_model(instance, conditions, options)?;
    let solution = solve(&mut model, options)?;
    let (verdict, samples) = (solution.verdict(), instance.instance());
    let contact = model
        .follow(&solution.minimum.parameters)
        .ok_or(FitError::NoStart)?;
    let friction = friction_at_rest(&model, &contact, samples.mu);
    InstanceFit::new(&mut model, &samples, solution.minimum, verdict, friction)
}

/// Limits of the signs of misfit.
const LIMITS: Limits = Limits {
    sigma_t_m: [0.5e-6, 3.5e-6],
    re_z_t_n_s_per_m: -0.05,
    residual_part: 0.006,
    rms_mu: 0.03,
};

/// Returns the signs that an instance does not follow the laws by which [`fit`] fitted it.
pub fn misfit(instance: &InstanceSeries<'_>, fit: &InstanceFit) -> Vec<InstanceMisfit> {
    LIMITS.signs(&Judged {
        sigma_t_m: fit.sigma_t_m,
        re_z_t_n_s_per_m: [fit.z_t_n_s_per_m.re, fit.z_t_std_n_s_per_m.re],
        agreement: &fit.agreement,
        z_m: instance.instance().z_m_corrected_n_s_per_m,
        z_m_model: &fit.series.z_m_model_n_s_per_m,
    })
}

/// Returns the model with a σ_t that was not fitted to this instance, such as a participant's average, and with τ and Z_p
/// from `constants`; Z_t and μ0 are refitted to the instance.
///
/// # Errors
/// If the lead-in is too short, or the model allows no such contact.
pub fn model_series(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
    sigma_t_m: f64,
    constants: &DynamicConstants,
) -> Result<ModelledSeries, FitError> {
    let plate_conditions = FitConditions {
        z_p_corrected_n_s_per_m: constants.z_p_n_s_per_m,
        ..*conditions
    };
    let mut model = lagged_model(instance, &plate_conditions, options)?;
    let parameters = model.assumed_parameters(sigma_t_m, constants.tau_s);
    let parameters = model.best_start([parameters]).ok_or(FitError::NoStart)?;
    let contact = model.contact(&parameters).ok_or(FitError::NoStart)?;
    let z_m_n_s_per_m = model_impedances(&mut model, &parameters).ok_or(FitError::NoStart)?;
    let mu0 = friction_at_rest(&model, &contact, instance.instance().mu).mu0;
    let lead = model.lead;
    let gap_m = model.gap[lead..].to_vec();
    let k_c = |(&gap_m, &a)| contact.stiffness_n_per_m(gap_m, a);
    let mu = |(&gap_m, &n)| mu0 * contact.friction_ratio(gap_m, n);
    Ok(ModelledSeries {
        z_m_n_s_per_m,
        k_c_n_per_m: gap_m
            .iter()
            .zip(&model.amplitude_m[lead..])
            .map(k_c)
            .collect(),
        mu: gap_m.iter().zip(&model.normal_n[lead..]).map(mu).collect(),
        gap_m,
    })
}

/// τ and Z_p of an instance's own fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicConstants {
    /// τ, s.
    pub tau_s: f64,
    /// Z_p with the fitted offset, N·s/m.
    pub z_p_n_s_per_m: Complex64,
}

/// Returns how σ_t, Z_t and τ depend on the assumed constants.
///
/// # Errors
/// Same as [`fit`].
pub fn sensitivities(
    instance: &InstanceSeries<'_>,
    conditions: &FitConditions,
    options: &DynamicOptions,
) -> Result<Sensitivities, FitError> {
    sensitivity::sensitivities(conditions, |conditions| {
        let mut model = lagged_model(instance, conditions, options)?;
        let parameters = solve(&mut model, options)?.minimum.parameters;
        Ok(Refit {
            ln_sigma_t: parameters[LN_SIGMA_T],
            z_t: Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]),
            tau_s: parameters[TAU_MS] * MS,
        })
    })
}

/// Returns the model with the assumed area, independent of the normal force.
fn lagged_model<'a>(
    instance: &InstanceSeries<'a>,
    conditions: &FitConditions,
    options: &DynamicOptions,
) -> Result<LaggedModel<'a>, FitError> {
    let reference_n = mean(instance.instance().normal_n);
    let mut model = LaggedModel::new(instance, conditions, options.lead_in_s, reference_n)?;
    // On a known mode the contact has the width of a circle of the assumed area.
    if model.width_square_per_m2.is_some() {
        model.set_laws(Laws::InDoubt);
    }
    Ok(model)
}

struct JointSolution {
    minimum: Minimum<PARAMETERS>,
    /// Estimate of τ without its bound, s, if the bound is active.
    unbounded_tau_s: Option<f64>,
}

fn solve(model: &mut LaggedModel<'_>, options: &DynamicOptions) -> Result<JointSolution, FitError> {
    let free_parameters = [LN_SIGMA_T, RE_Z_T, IM_Z_T, TAU_MS, IM_OFFSET];
    let bound_parameters = [LN_SIGMA_T, RE_Z_T, IM_Z_T, IM_OFFSET];
    let offset_count = usize::from(options.plate_offset);
    let by_error = model.calibration.by_parameter();
    let (free, free_at_bound) = (
        &free_parameters[..4 + offset_count],
        &bound_parameters[..3 + offset_count],
    );
    let starts: Vec<_> = TAU_STARTS_S
        .iter()
        .flat_map(|&tau_s| {
            let offset_start = options
                .plate_offset
                .then(|| start_with_offset(model, tau_s));
            [start(model, tau_s), offset_start.flatten()]
        })
        .flatten()
        .collect();
    let mut solutions: Vec<JointSolution> = Vec::with_capacity(starts.len());
    for start in starts {
        let unbounded_minimum = minimise(model, start, free, &by_error);
        let tau_ms = unbounded_minimum.parameters[TAU_MS];
        solutions.push(if tau_ms >= 0.0 {
            JointSolution {
                minimum: unbounded_minimum,
                unbounded_tau_s: None,
            }
        } else {
            let mut bound_start = unbounded_minimum.parameters;
            bound_start[TAU_MS] = 0.0;
            JointSolution {
                minimum: minimise(model, bound_start, free_at_bound, &by_error),
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

fn start(model: &mut LaggedModel<'_>, tau_s: f64) -> Option<[f64; PARAMETERS]> {
    let candidates: Vec<_> = sigma_starts()
        .map(|sigma_t_m| model.assumed_parameters(sigma_t_m, tau_s))
        .collect();
    model.best_start(candidates)
}

/// Returns a start with a plate that may already differ from the unloaded one.
fn start_with_offset(model: &mut LaggedModel<'_>, tau_s: f64) -> Option<[f64; PARAMETERS]> {
    let candidates = sigma_starts().filter_map(|sigma_t_m| {
        let mut parameters = model.assumed_parameters(sigma_t_m, tau_s);
        let fit = model.fit_candidate(&parameters)?;
        (parameters[RE_Z_T], parameters[IM_Z_T]) = (fit.z_t.re, fit.z_t.im);
        parameters[IM_OFFSET] = fit.reactance;
        Some((fit.square, parameters))
    });
    let best = candidates.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(best.1)
}

impl JointSolution {
    fn verdict(&self) -> FitVerdict {
        let minimum = &self.minimum;
        if let Some(reason) = &minimum.failure {
            return FitVerdict::NotConverged {
                reason: reason.clone(),
            };
        }
        let z_t = Complex64::new(minimum.parameters[RE_Z_T], minimum.parameters[IM_Z_T]);
        // E|δZ_t|² = Var Re Z_t + Var Im Z_t.
        let z_t_std = minimum.std(RE_Z_T).hypot(minimum.std(IM_Z_T));
        let errors = [
            StandardError::relative(FitParameter::SigmaT, minimum.std(LN_SIGMA_T)),
            StandardError::relative(FitParameter::ZT, z_t_std / z_t.norm()),
            StandardError {
                parameter: FitParameter::Tau,
                std: minimum.std(TAU_MS) * MS,
                limit: IDENTIFIABLE_TAU_STD_S,
            },
        ];
        match (find_unidentified(errors), self.unbounded_tau_s) {
            (Some(verdict), _) => verdict,
            (None, Some(unbounded_tau_s)) => FitVerdict::LagAtBound { unbounded_tau_s },
            (None, None) => FitVerdict::Converged,
        }
    }
}
