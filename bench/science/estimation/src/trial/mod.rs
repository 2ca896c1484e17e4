//! One fit of all instances of a trial, without assumed constants of the skin.
//!
//! σ_t, Z_t and the plate's offset belong to an instance; S, q0, η and τ are shared by all instances of a trial and fitted. A
//! single instance hardly separates S from τ, but a trial does: S follows from the film's force (Huloux 2021, Eq. 14) and the
//! measured normal force, q0 from the gap at rest (Eq. 16), η from the phase of the contact (Eq. 6). Only q0 E/(1 − ν²) and p0
//! S enter, so q0 is the value for the assumed E and ν.
//!
//! The impedance, the gap's lag and the normal force are those of [`dynamic`](super::dynamic); in addition the skin has inertia
//! while the amplitude changes (`transient.rs`). With r_i the 2n real and imaginary parts of Z_m,model − Z_m of instance i and
//! V_i their covariance (`scatter.rs`), the sum
//!
//! ```text
//! C = Σ_i r_iᵀV_i⁻¹ r_i + Σ_j ((θ_j − m_j)/s_j)²
//! ```
//!
//! is minimised: −2 ln of the posterior for normal residuals and normal [priors](TrialPriors) m_j ± s_j, up to a constant while
//! the V_i are fixed. Unknowns of an instance are ln σ_t, Re Z_t, Im Z_t, the plate's offset Δ (two parts), and the angle φ and
//! residual mobility y_r of other modes; σ_t and Z_t have no prior. Shared are ln S, ln q0, ln η, ln τ, ν, ln T, p
//! (`lagged_model.rs`), five deviations of the plate from its predicted course (`plate.rs`), tilt and bow of the amplitude
//! along the plate, and common parts of φ and y_r.
//!
//! 1. Each of up to four pairs of S and τ starts from the best q0 and σ_t of a grid and descends with V = (0.01 N·s/m)² and
//!    narrowed priors of the extensions (`search.rs`).
//! 2. The best minimum is refined three times: trends within instances, the plate's course, the skin's transients and V are
//!    computed at it and held fixed, and C is minimised again (`arrowhead`).
//! 3. Without later readings of the plate, its damping is freed where the Bayesian information criterion favours that.
//! 4. The covariance follows from residuals, priors and the errors of the calibration; the friction is fitted to the contact
//!    found (`friction.rs`).

mod friction;
mod friction_spread;
mod members;
mod misfit;
mod plate;
mod prior;
mod scatter;
mod search;

use num_complex::Complex64;

use friction::{RatioSamples, TrialFriction};
use friction_spread::FrictionSpread;
use members::{
    AREA, Covariance, FILM_MEAN, GROWTH, LAG_GROWTH, LOSS_FACTOR, Member, OWN, ParameterSlopes, Q0,
    SIGMA_T, Shared, TAU, TILT_DISTANCE_M, TISSUE, TrialMinimum,
};
pub use misfit::Misfit;
pub use plate::{PlateReadings, PlateReference};
pub use prior::{LogNormal, Normal, TrialPriors};
use search::Search;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::fit_verdict::{FitParameter, FitVerdict, IDENTIFIABLE_RELATIVE_STD, find_unidentified};
use super::instance_fit::{InstanceFit, friction_at_rest, modelled_ratio, modelled_ratio_slopes};
use super::lagged_model::LaggedModel;
use super::least_squares::{ImpedanceModel, Minimum};
use super::series::{InstanceSeries, mean};
use contact::CalibrationErrors;
use contact::calibration_errors::OF_OTHER_MODES;
use contact::parameters::FILM_MOBILITY;
use contact::residual_noise::ResidualNoise;
use contact::uncertain::{LogUncertain, Uncertain};

/// Options of a trial's fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOptions {
    /// Time before each instance from which its gap is integrated, s. Default 20 ms, some ten τ.
    pub lead_in_s: f64,
    /// Priors of the parameters.
    pub priors: TrialPriors,
}

impl Default for TrialOptions {
    fn default() -> Self {
        Self {
            lead_in_s: 0.02,
            priors: TrialPriors::default(),
        }
    }
}

/// An instance and its position on the plate.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The instance.
    pub series: InstanceSeries<'a>,
    /// Position of its middle along the plate, from the plate's centre, m.
    pub off_centre_m: f64,
}

/// Parameters that the instances of a trial share.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedFit {
    /// Whether the parameters, including those of the instances, may be used.
    pub verdict: FitVerdict,
    /// Apparent contact area S under the mean normal force of all instances, m².
    pub contact_area_m2: LogUncertain,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: LogUncertain,
    /// Loss factor η.
    pub loss_factor: LogUncertain,
    /// Levitation lag τ at the mean gap of all instances, s.
    pub tau_s: LogUncertain,
    /// Exponent ν of the area's growth with the normal force.
    pub area_exponent: Uncertain,
    /// Time over which the film averages the squared amplitude, s.
    pub film_mean_s: LogUncertain,
    /// Exponent of the lag's growth with the gap.
    pub lag_exponent: Uncertain,
    /// Signs that the model does not hold; if there are any, the standard errors cannot be trusted.
    pub misfit: Vec<Misfit>,
    /// Floor φ of friction as a fraction of μ0; `None` if the measured friction could not be fitted.
    pub friction_floor: Option<Uncertain>,
    /// Lag of the lateral force, s; `None` if the measured friction could not be fitted.
    pub lateral_lag_s: Option<Uncertain>,
}

/// Result of a trial's fit.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialFit {
    /// Parameters that the instances share.
    pub shared: SharedFit,
    /// Each instance, in the order given.
    pub instances: Vec<InstanceFit>,
}

/// Fits all instances of a trial, using the plate's `readings`.
///
/// # Errors
/// If there is no instance, a lead-in is too short, or the model allows no such contacts.
pub fn fit(
    places: &[Placed<'_>],
    conditions: &FitConditions,
    readings: &PlateReadings,
    options: &TrialOptions,
) -> Result<TrialFit, FitError> {
    let instances: Vec<InstanceSeries<'_>> = places.iter().map(|place| place.series).collect();
    let forces = instances
        .iter()
        .map(|instance| mean(instance.instance().normal_n));
    let reference_n = forces.sum::<f64>() / instances.len() as f64;
    let z_p = conditions.z_p_corrected_n_s_per_m;
    let mut members = Vec::with_capacity(instances.len());
    for (instance, place) in instances.iter().zip(places) {
        let model = LaggedModel::new(instance, conditions, options.lead_in_s, reference_n)?;
        members.push((model, place.off_centre_m / TILT_DISTANCE_M));
    }
    let times_s: Vec<f64> = members.iter().map(|member| member.0.middle_s).collect();
    let offsets = plate::offsets(&times_s, readings, z_p, &options.priors, None);
    let members: Vec<Member<'_>> = members
        .into_iter()
        .zip(offsets)
        .map(|((model, position), offset)| Member {
            model,
            offset,
            position,
        })
        .collect();
    if members.is_empty() {
        return Err(FitError::NoStart);
    }
    let mut search = Search::new(members, readings, options.priors);
    let minimum = search.solve()?;
    report(search, &instances, minimum, &conditions.calibration)
}

fn report(
    mut search: Search<'_>,
    instances: &[InstanceSeries<'_>],
    minimum: TrialMinimum,
    calibration: &CalibrationErrors,
) -> Result<TrialFit, FitError> {
    let mut by_error = calibration.by_parameter();
    // The component common to all places and that of each place add in quadrature.
    by_error[(FILM_MOBILITY, OF_OTHER_MODES)] =
        std::f64::consts::SQRT_2 * search.priors.residual_mobility_std_m_per_n_s;
    search
        .follow_other_modes(&minimum)
        .ok_or(FitError::NoStart)?;
    let residuals = search.residuals_at(&minimum);
    let covariance = search.covariance(&minimum, &by_error);
    let verdict = verdict(&minimum, covariance.as_ref());
    let std = |index: usize| {
        covariance.as_ref().map_or(f64::INFINITY, |covariance| {
            covariance.shared[(index, index)].sqrt()
        })
    };
    let log_uncertain = |index: usize| LogUncertain {
        value: minimum.shared[index].exp(),
        ln_std: std(index),
    };
    let uncertain = |index: usize| Uncertain {
        value: minimum.shared[index],
        std: std(index),
    };
    let members = &mut search.members;
    let parameter_slopes: Vec<ParameterSlopes> = members
        .iter()
        .zip(&minimum.own)
        .map(|(member, own)| member.parameter_slopes(&member.parameters(&minimum.shared, own)))
        .collect();
    let friction = friction(members, instances, &minimum);
    let spread = friction.as_ref().zip(covariance.as_ref());
    let spread = spread.and_then(|(friction, covariance)| {
        FrictionSpread::new(friction, &parameter_slopes, &minimum, covariance, &by_error)
    });
    let tau_s = tau_at_mean_gap(members, &minimum, covariance.as_ref());
    let mut fits = Vec::with_capacity(instances.len());
    for (index, (member, instance)) in members.iter_mut().zip(instances).enumerate() {
        let parameters = member.parameters(&minimum.shared, &minimum.own[index]);
        let (z_m, residuals) = (member.model.z_m, &residuals[index]);
        let shapes: Vec<f64> = (0..z_m.len())
            .map(|i| member.model.noise_shape(i))
            .collect();
        let instance_minimum = Minimum {
            parameters,
            z_m: z_m.iter().zip(residuals).map(|(z, r)| z + r).collect(),
            squares: residuals.iter().map(Complex64::norm_sqr).sum(),
            failure: None,
            covariance: covariance
                .as_ref()
                .map(|covariance| parameter_slopes[index].covariance(covariance, index, &by_error)),
            noise: ResidualNoise::of(residuals, &shapes, OWN),
        };
        let (model, samples) = (&mut member.model, instance.instance());
        let contact = model.follow(&parameters).ok_or(FitError::NoStart)?;
        let law = match (&friction, &spread, &instance_minimum.covariance) {
            (Some(friction), Some(spread), Some(covariance)) => {
                spread.law(friction, index, covariance)
            }
            (Some(friction), ..) => friction.law(index),
            (None, ..) => friction_at_rest(model, &contact, samples.mu),
        };
        let fit = InstanceFit::new(model, &samples, instance_minimum, verdict.clone(), law)?;
        fits.push(fit);
    }
    let trial_friction = friction.as_ref().map(|friction| {
        let stds = [friction.floor.std, friction.lag_s.std];
        let [floor, lag_s] = spread.as_ref().map_or(stds, |spread| spread.stds(stds));
        [
            Uncertain {
                std: floor,
                ..friction.floor
            },
            Uncertain {
                std: lag_s,
                ..friction.lag_s
            },
        ]
    });
    let misfit = misfit::signs(
        &minimum.shared,
        &search.shared_priors(),
        search.plate_deviation(&minimum),
        &fits,
    );
    Ok(TrialFit {
        shared: SharedFit {
            verdict,
            contact_area_m2: log_uncertain(AREA),
            q0_rad_per_m: log_uncertain(Q0),
            loss_factor: log_uncertain(LOSS_FACTOR),
            tau_s,
            area_exponent: uncertain(GROWTH),
            film_mean_s: log_uncertain(FILM_MEAN),
            lag_exponent: uncertain(LAG_GROWTH),
            misfit,
            friction_floor: trial_friction.map(|[floor, _]| floor),
            lateral_lag_s: trial_friction.map(|[_, lag_s]| lag_s),
        },
        instances: fits,
    })
}

/// Returns τ at the mean gap of all instances.
fn tau_at_mean_gap(
    members: &mut [Member<'_>],
    minimum: &TrialMinimum,
    covariance: Option<&Covariance>,
) -> LogUncertain {
    let mut ln_gap = 0.0;
    for (member, own) in members.iter_mut().zip(&minimum.own) {
        let parameters = member.parameters(&minimum.shared, own);
        if member.model.follow(&parameters).is_some() {
            ln_gap += member.model.ln_mean_gap() / minimum.own.len() as f64;
        }
    }
    // ln τ at the mean ln x̄ of the instances is ln τ + p ln(x̄/10 µm), for x̄ held fixed.
    let mut slopes = Shared::zeros();
    (slopes[TAU], slopes[LAG_GROWTH]) = (1.0, ln_gap);
    LogUncertain {
        value: minimum.shared.dot(&slopes).exp(),
        ln_std: covariance.map_or(f64::INFINITY, |covariance| {
            slopes.dot(&(covariance.shared * slopes)).sqrt()
        }),
    }
}

/// Fits the trial's friction to the contact at a minimum.
fn friction(
    members: &mut [Member<'_>],
    instances: &[InstanceSeries<'_>],
    minimum: &TrialMinimum,
) -> Option<TrialFriction> {
    let mut ratios = Vec::with_capacity(members.len());
    for (member, own) in members.iter_mut().zip(&minimum.own) {
        let parameters = member.parameters(&minimum.shared, own);
        let contact = member.model.follow(&parameters)?;
        let ratio = modelled_ratio(&member.model, &contact);
        let slopes = modelled_ratio_slopes(&member.model, &contact, &ratio);
        ratios.push((ratio, slopes));
    }
    let samples: Vec<RatioSamples<'_>> = members
        .iter()
        .zip(ratios)
        .zip(instances)
        .map(|((member, (ratio, ratio_slopes)), instance)| RatioSamples {
            ratio,
            ratio_slopes,
            normal_n: member.model.normal_n,
            lead: member.model.lead,
            mu: instance.instance().mu,
            time_s: member.model.time_s,
            middle_s: member.model.middle_s,
        })
        .collect();
    friction::fit(&samples, members.first()?.model.interval_s)
}

fn verdict(minimum: &TrialMinimum, covariance: Option<&Covariance>) -> FitVerdict {
    if !minimum.converged {
        return FitVerdict::NotConverged {
            reason: "the search for the least squares did not end".to_owned(),
        };
    }
    let Some(covariance) = covariance else {
        return FitVerdict::NotIdentifiable {
            parameter: FitParameter::SigmaT,
            std: f64::INFINITY,
        };
    };
    let instance_errors = minimum.own.iter().enumerate().flat_map(|(index, own)| {
        let own_covariance = &covariance.blocks[index].own;
        // Relative error of |Z_t|: √(E|δZ_t|²)/|Z_t|.
        let variance = |k: usize| own_covariance[(k, k)];
        let tissue_variance: f64 = TISSUE.map(variance).iter().sum();
        let tissue_square: f64 = TISSUE.map(|k| own[k] * own[k]).iter().sum();
        [
            (FitParameter::SigmaT, variance(SIGMA_T).sqrt()),
            (FitParameter::ZT, (tissue_variance / tissue_square).sqrt()),
        ]
    });
    let area = (
        FitParameter::ContactArea,
        covariance.shared[(AREA, AREA)].sqrt(),
    );
    let errors = instance_errors.chain([area]);
    let errors = errors.map(|(parameter, std)| (parameter, std, IDENTIFIABLE_RELATIVE_STD));
    find_unidentified(errors).unwrap_or(FitVerdict::Converged)
}
