//! Result of fitting the lagged model to one instance.

use nalgebra::SVector;
use num_complex::Complex64;

use super::estimated_series::{EstimatedSeries, GapLaw, LoadTrend, MeasuredSamples, estimate};
use super::fit_agreement::{Agreement, agreement};
use super::fit_error::FitError;
use super::fit_verdict::FitVerdict;
use super::friction_law::{FrictionLaw, SensedFriction};
use super::lagged_model::{GAP_PARAMETERS, LaggedModel, finger_scale, plate_offset};
use super::least_squares::Minimum;
use super::series::{InstanceSamples, mean};
use contact::Contact;
use contact::FittedFinger;
use contact::inversion::{Dependent, Inversion};
use contact::parameters::{
    FINGER_SLOPES, IM_OFFSET, IM_Z_T, LAG_EXPONENT, LN_FORCE, LN_SIGMA_T, LoadSlopes, MS,
    PARAMETERS, RE_OFFSET, RE_Z_T, RESIDUAL_MOBILITY, RESIDUAL_SLOPES, TAU_MS, Z_P_SLOPES,
    Z_T_SLOPES,
};

/// Result of `dynamic` or `trial` for one instance.
#[derive(Debug, Clone, PartialEq)]
pub struct InstanceFit {
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
    /// Levitation lag τ, s; at the instance's mean gap if it grows with the gap.
    pub tau_s: f64,
    /// Standard error of `tau_s`, s; 0 at the bound.
    pub tau_std_s: f64,
    /// Change of the plate's impedance relative to the unloaded plate, N·s/m: imaginary for a shift of resonance, real for a
    /// change of damping; 0 where a part was held fixed.
    pub plate_offset_n_s_per_m: Complex64,
    /// Standard errors of the offset's real and imaginary part, N·s/m; 0 where a part was held fixed.
    pub plate_offset_std_n_s_per_m: Complex64,
    /// Friction without vibration μ0.
    pub mu0: f64,
    /// Standard error of `mu0`.
    pub mu0_std: f64,
    /// Mean normal force ⟨f_c⟩ over the instance, N.
    pub normal_n: f64,
    /// Agreement of fit and measurement.
    pub agreement: Agreement,
    /// Stiffness, gap and friction over time.
    pub series: EstimatedSeries,
    /// The fitted parameters with their covariance, for samples beyond this instance: [`contact::self_sensed`],
    /// [`contact::live_estimator`].
    pub finger: FittedFinger,
}

impl InstanceFit {
    pub(super) fn new(
        model: &mut LaggedModel<'_>,
        samples: &InstanceSamples<'_>,
        minimum: Minimum<PARAMETERS>,
        verdict: FitVerdict,
        friction: FrictionLaw<PARAMETERS>,
    ) -> Result<Self, FitError> {
        let friction = friction.with_lateral_error(model.calibration.lateral_force_relative);
        let contact = model.follow(&minimum.parameters).ok_or(FitError::NoStart)?;
        let lag = lag_at_mean_gap(model, &minimum.parameters);
        let finger = fitted_finger(model, contact, &minimum, lag.value);
        let series = estimated_series(model, samples, &minimum, &finger, &friction);
        let sensed_friction = SensedFriction {
            estimated_mu: &series.mu,
            modelled_mu: &modelled_friction(model, &contact, &friction),
            normal_n: model.normal_n,
            interval_s: model.interval_s,
        };
        let sensor_mu = sensed_friction.read(friction.lag_s);
        let mu0 = Dependent {
            value: friction.mu0,
            slopes: friction.slopes.into(),
            noise: friction.mu0_scatter(),
        };
        let std = |parameter: usize| minimum.std(parameter);
        Ok(Self {
            verdict,
            sigma_t_m: contact.sigma_t_m(),
            sigma_t_std_m: contact.sigma_t_m() * std(LN_SIGMA_T),
            z_t_n_s_per_m: finger.inversion.z_t,
            z_t_std_n_s_per_m: Complex64::new(std(RE_Z_T), std(IM_Z_T)),
            tau_s: lag.value,
            tau_std_s: finger.inversion.std(&lag),
            plate_offset_n_s_per_m: plate_offset(&minimum.parameters),
            plate_offset_std_n_s_per_m: Complex64::new(std(RE_OFFSET), std(IM_OFFSET)),
            mu0: friction.mu0,
            mu0_std: finger.inversion.std(&mu0),
            normal_n: mean(samples.normal_n),
            agreement: agreement(model.z_m, samples.mu, &series, &sensor_mu),
            series,
            finger,
        })
    }
}

/// Returns τ at the instance's mean gap, s, after [`LaggedModel::follow`].
fn lag_at_mean_gap(
    model: &LaggedModel<'_>,
    parameters: &[f64; PARAMETERS],
) -> Dependent<PARAMETERS> {
    // τ at the mean gap x̄ is τ (x̄/10 µm)^p: ∂/∂τ = (x̄/10 µm)^p, ∂/∂p = τ (x̄/10 µm)^p ln(x̄/10 µm), for x̄ held fixed.
    let ln_gap = model.ln_mean_gap();
    let growth = (parameters[LAG_EXPONENT] * ln_gap).exp();
    let tau_s = parameters[TAU_MS] * MS * growth;
    let mut slopes = SVector::zeros();
    slopes[TAU_MS] = MS * growth;
    slopes[LAG_EXPONENT] = tau_s * ln_gap;
    Dependent {
        value: tau_s,
        slopes,
        noise: 0.0,
    }
}

/// Returns the parameters of a minimum in the form for further samples.
fn fitted_finger(
    model: &LaggedModel<'_>,
    contact: Contact,
    minimum: &Minimum<PARAMETERS>,
    tau_s: f64,
) -> FittedFinger {
    let parameters = &minimum.parameters;
    FittedFinger {
        inversion: Inversion {
            contact,
            load: LoadSlopes::default(),
            carrier_rad_per_s: model.carrier_rad_per_s,
            z_p: model.z_p + plate_offset(parameters),
            z_t: Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]),
            z_t_slopes: Z_T_SLOPES,
            z_p_slopes: Z_P_SLOPES,
            finger_scale: finger_scale(parameters),
            finger_slopes: FINGER_SLOPES,
            residual_mobility: Complex64::I * parameters[RESIDUAL_MOBILITY],
            residual_slopes: RESIDUAL_SLOPES,
            covariance: minimum.covariance,
        },
        tau_s,
        z_m_noise: minimum.noise,
    }
}

/// Returns stiffness, gap and friction from the measured Z_m without the skin's inertia.
fn estimated_series(
    model: &LaggedModel<'_>,
    samples: &InstanceSamples<'_>,
    minimum: &Minimum<PARAMETERS>,
    finger: &FittedFinger,
    friction: &FrictionLaw<PARAMETERS>,
) -> EstimatedSeries {
    let noise_std = |amplitude_m: &f64| minimum.noise.std(amplitude_m.recip());
    let laws = model.sample_laws(&minimum.parameters);
    let measurement = MeasuredSamples {
        time_s: samples.time_s,
        z_m: &model.z_m_without_inertia(),
        z_m_std: &samples
            .amplitude_m
            .iter()
            .map(noise_std)
            .collect::<Vec<_>>(),
        amplitude_m: samples.amplitude_m,
        normal_n: &model.normal_n[model.lead..],
        load_trend: Some(LoadTrend {
            loads: &model.loads,
            trend: &model.trend,
            first: model.lead,
            laws: laws.as_deref(),
        }),
    };
    estimate(
        &finger.inversion,
        GapLaw::Amplitude,
        friction,
        &measurement,
        minimum.z_m.clone(),
    )
}

/// Returns μ/μ0 by Eq. 19 after [`LaggedModel::follow`], with the lead-in.
pub(super) fn modelled_ratio(model: &LaggedModel<'_>, contact: &Contact) -> Vec<f64> {
    let samples = model.gap.iter().zip(model.normal_n).enumerate();
    samples
        .map(|(sample, (&x, &n))| model.contact_at(contact, sample).friction_ratio(x, n))
        .collect()
}

/// Returns the friction of a law with the modelled μ/μ0, after [`LaggedModel::follow`], with the lead-in.
fn modelled_friction(
    model: &LaggedModel<'_>,
    contact: &Contact,
    friction: &FrictionLaw<PARAMETERS>,
) -> Vec<f64> {
    let ratios = modelled_ratio(model, contact).into_iter();
    let samples = ratios.zip(model.time_s);
    samples
        .map(|(ratio, &time_s)| friction.mu(ratio, time_s))
        .collect()
}

/// Returns μ0 = Σ m μ/Σ m² with m the modelled μ/μ0, after [`LaggedModel::follow`].
pub(super) fn friction_at_rest(
    model: &LaggedModel<'_>,
    contact: &Contact,
    mu: &[f64],
) -> FrictionLaw<PARAMETERS> {
    let all_ratios = modelled_ratio(model, contact);
    let ratios = &all_ratios[model.lead..];
    let power: f64 = ratios.iter().map(|m| m * m).sum();
    let mu0 = ratios.iter().zip(mu).map(|(m, mu)| m * mu).sum::<f64>() / power;
    let squares: f64 = ratios
        .iter()
        .zip(mu)
        .map(|(ratio, mu)| (mu - mu0 * ratio).powi(2))
        .sum();
    // Var μ0 = s²/Σ m², s² the residuals' variance; crosstalk κ, common to all samples, changes μ0 by κ Σ m/Σ m².
    let freedom = (ratios.len() - 1) as f64;
    let crosstalk = model.calibration.lateral_per_normal * ratios.iter().sum::<f64>() / power;
    FrictionLaw::paper(
        mu0,
        (squares / freedom / power).sqrt().hypot(crosstalk),
        friction_slopes(model, contact, mu, mu0, &all_ratios),
    )
}

/// Returns ∂(μ/μ0)/∂parameter for the parameters in [`GAP_PARAMETERS`], after [`LaggedModel::follow`], with the lead-in.
pub(super) fn modelled_ratio_slopes(
    model: &LaggedModel<'_>,
    contact: &Contact,
    ratios: &[f64],
) -> [Vec<f64>; GAP_PARAMETERS.len()] {
    let sigma = contact.sigma_t_m();
    let mut slopes: [Vec<f64>; GAP_PARAMETERS.len()] =
        std::array::from_fn(|_| Vec::with_capacity(ratios.len()));
    for (sample, &ratio) in ratios.iter().enumerate() {
        let contact = model.contact_at(contact, sample);
        let fixed_gap_slopes =
            contact.friction_ratio_slopes(model.gap[sample], model.normal_n[sample]);
        let gap_slopes = model.gap_slopes_m(sample).into_iter().zip(GAP_PARAMETERS);
        for (slopes, (gap_slope, parameter)) in slopes.iter_mut().zip(gap_slopes) {
            let direct_slope =
                fixed_gap_slopes.by_parameter(parameter, &model.loads.slopes[sample]);
            // m = e^((x_t⁰ − x)/σ_t): dm/dθ = ∂m/∂θ − (m/σ_t) ∂x/∂θ.
            slopes.push(direct_slope - ratio / sigma * gap_slope);
        }
    }
    slopes
}

/// Returns ∂μ0/∂parameter for the least-squares μ0 of the modelled μ/μ0.
fn friction_slopes(
    model: &LaggedModel<'_>,
    contact: &Contact,
    mu: &[f64],
    mu0: f64,
    ratios: &[f64],
) -> [f64; PARAMETERS] {
    let instance_ratios = &ratios[model.lead..];
    let power: f64 = instance_ratios.iter().map(|m| m * m).sum();
    let mut slopes = [0.0; PARAMETERS];
    let ratio_slopes = modelled_ratio_slopes(model, contact, ratios);
    for (parameter, ratio_slope) in GAP_PARAMETERS.into_iter().zip(&ratio_slopes) {
        let samples = instance_ratios
            .iter()
            .zip(mu)
            .zip(&ratio_slope[model.lead..]);
        // ∂μ0/∂θ = (Σ μ m′ − μ0 · 2 Σ m m′)/Σ m², m′ = ∂m/∂θ.
        let weighted_slope: f64 = samples
            .map(|((ratio, mu), slope)| (mu - 2.0 * mu0 * ratio) * slope)
            .sum();
        slopes[parameter] = weighted_slope / power;
    }
    // The measured friction is the lateral force divided by the normal force.
    slopes[LN_FORCE] -= mu0;
    slopes
}
