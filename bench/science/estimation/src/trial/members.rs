//! Parameters of an instance, parameters shared by a trial's instances, and the model's parameters as a function of both.
//!
//! With an instance's own parameters o, the shared s, and its place u in units of 30 mm, the model's parameters θ are
//!
//! ```text
//! τ = e^(s_τ),  T = e^(s_T)                        the other parameters as they are
//! Δ = o_Δ + mean + Σ_k s_k by_course_k             plate: its predicted course, and deviations from it (`plate.rs`)
//! φ = o_φ + s_φ,  y_r = o_y + s_y                  other modes, at this place and at all
//! ln r = s_tilt u + s_bow u²                       amplitude along the plate
//! κ = s_w, or s_w 4S/(π λ²)                        width of the contact, where the wavelength λ is unknown or known
//! ```
//!
//! Laws in doubt that are not free are held at those published, or at no width.

use nalgebra::SMatrix;

use super::layout::{
    FreeLaws, InstanceParameter, LAWS, OWN, Own, SHARED, Shared, SharedParameter, courses,
};
use super::plate::{self, OffsetPrior, PlateReadings};
use super::request::{PlacedInstance, TrialOptions};
use crate::conditions::FitConditions;
use crate::fit_error::FitError;
use crate::lagged_model::{LaggedModel, Laws};
use crate::series::{InstanceSamples, mean};
use arrowhead::{ArrowCovariance, ArrowMinimum, ParameterPoint};
use contact::calibration_errors::{ByError, ERRORS};
use contact::parameters::{
    AREA_EXPONENT, FILM_MEAN_MS, FINGER_ANGLE, IM_OFFSET, LAG_EXPONENT, LN_AREA, LN_LOSS_FACTOR,
    LN_Q0, LN_RATIO, MS, PARAMETERS, RE_OFFSET, RESIDUAL_MOBILITY, TAU_MS,
};

pub(super) type TrialMinimum = ArrowMinimum<OWN, SHARED>;
pub(super) type Step = ParameterPoint<OWN, SHARED>;
pub(super) type Covariance = ArrowCovariance<OWN, SHARED, ERRORS>;

/// Distance along the plate at which tilt and bow are stated, m: half of the published central part.
pub(super) const TILT_DISTANCE_M: f64 = 0.03;

/// Effect of a shared parameter on the model's parameters, given by their indices.
enum Effect {
    /// It is one of the model's parameters.
    Identity(usize),
    /// It is the logarithm of a time in s; the model's is in ms.
    Time(usize),
    /// Two of the model's parameters are linear in it, with these slopes.
    Linear([(usize, f64); 2]),
}

/// An instance of a trial.
pub(super) struct Member<'a> {
    pub(super) model: LaggedModel<'a>,
    /// Samples of the instance, without its lead-in.
    pub(super) samples: InstanceSamples<'a>,
    /// Prior of the plate's offset.
    pub(super) offset: OffsetPrior,
    /// Distance from the plate's centre, in units of [`TILT_DISTANCE_M`].
    pub(super) position: f64,
    /// Laws in doubt that are fitted.
    pub(super) free_laws: FreeLaws,
}

impl Member<'_> {
    /// Returns the model's parameters.
    pub(super) fn parameters(&self, shared: &Shared, own: &Own) -> [f64; PARAMETERS] {
        let mut parameters = [0.0; PARAMETERS];
        for parameter in InstanceParameter::ALL {
            parameters[parameter.model_index()] = own[parameter];
        }
        for parameter in SharedParameter::ALL {
            match self.effect(parameter) {
                Effect::Identity(index) => parameters[index] = shared[parameter],
                Effect::Time(index) => parameters[index] = shared[parameter].exp() / MS,
                Effect::Linear(_) => {}
            }
        }
        let offset = self.offset.value(courses(shared));
        parameters[RE_OFFSET] += offset.re;
        parameters[IM_OFFSET] += offset.im;
        parameters[FINGER_ANGLE] += shared[SharedParameter::Angle];
        parameters[RESIDUAL_MOBILITY] += shared[SharedParameter::ResidualMobility];
        parameters[LN_RATIO] = shared[SharedParameter::Tilt] * self.position
            + shared[SharedParameter::Bow] * self.position.powi(2);
        parameters
    }

    /// Changes the laws in doubt that are fitted.
    pub(super) fn set_free_laws(&mut self, free_laws: FreeLaws) {
        self.free_laws = free_laws;
        self.model.set_laws(if free_laws.contains(&true) {
            Laws::InDoubt
        } else {
            Laws::Published
        });
    }

    /// Returns the effect of a shared parameter on the model's parameters.
    fn effect(&self, parameter: SharedParameter) -> Effect {
        let single = |index, slope| Effect::Linear([(index, slope), (index, 0.0)]);
        match parameter {
            SharedParameter::Law(law) if !self.free_laws[law as usize] => {
                single(law.model_index(), 0.0)
            }
            SharedParameter::Law(law) => Effect::Identity(law.model_index()),
            SharedParameter::LnArea => Effect::Identity(LN_AREA),
            SharedParameter::LnQ0 => Effect::Identity(LN_Q0),
            SharedParameter::LnLossFactor => Effect::Identity(LN_LOSS_FACTOR),
            SharedParameter::LnTau => Effect::Time(TAU_MS),
            SharedParameter::AreaExponent => Effect::Identity(AREA_EXPONENT),
            SharedParameter::LnFilmMean => Effect::Time(FILM_MEAN_MS),
            SharedParameter::LagExponent => Effect::Identity(LAG_EXPONENT),
            SharedParameter::Course(course) => {
                let slope = self.offset.by_course[course];
                Effect::Linear([(RE_OFFSET, slope.re), (IM_OFFSET, slope.im)])
            }
            SharedParameter::Tilt => single(LN_RATIO, self.position),
            SharedParameter::Bow => single(LN_RATIO, self.position.powi(2)),
            SharedParameter::Angle => single(FINGER_ANGLE, 1.0),
            SharedParameter::ResidualMobility => single(RESIDUAL_MOBILITY, 1.0),
        }
    }

    /// Returns the derivatives of the model's parameters by those of the instance and those of the trial.
    pub(super) fn parameter_slopes(&self, parameters: &[f64; PARAMETERS]) -> ParameterSlopes {
        let mut by_own = SMatrix::<f64, PARAMETERS, OWN>::zeros();
        for parameter in InstanceParameter::ALL {
            by_own[(parameter.model_index(), parameter as usize)] = 1.0;
        }
        let mut by_shared = SMatrix::<f64, PARAMETERS, SHARED>::zeros();
        for parameter in SharedParameter::ALL {
            let mut column = by_shared.column_mut(parameter.position());
            match self.effect(parameter) {
                Effect::Identity(index) => column[index] = 1.0,
                Effect::Time(index) => column[index] = parameters[index],
                Effect::Linear(effects) => {
                    for (index, slope) in effects {
                        column[index] += slope;
                    }
                }
            }
        }
        ParameterSlopes { by_own, by_shared }
    }
}

/// Returns the instances of a trial with the plate's likely course. The area is S at the mean of their mean normal forces.
pub(super) fn members<'a>(
    places: &[PlacedInstance<'a>],
    conditions: &FitConditions,
    readings: &PlateReadings,
    options: &TrialOptions,
) -> Result<Vec<Member<'a>>, FitError> {
    let forces = places
        .iter()
        .map(|place| mean(place.series.instance().normal_n));
    let reference_n = forces.sum::<f64>() / places.len() as f64;
    let mut models = Vec::with_capacity(places.len());
    for place in places {
        let lead_in_s = options.lead_in_s;
        models.push(LaggedModel::new(
            &place.series,
            conditions,
            lead_in_s,
            reference_n,
        )?);
    }
    let times_s: Vec<f64> = models.iter().map(|model| model.middle_s).collect();
    let z_p = conditions.z_p_corrected_n_s_per_m;
    let offsets = plate::offsets(&times_s, readings, z_p, &options.priors, None);
    let members = places.iter().zip(models).zip(offsets);
    Ok(members
        .map(|((place, model), offset)| Member {
            model,
            samples: place.series.instance(),
            offset,
            position: place.off_centre_m / TILT_DISTANCE_M,
            free_laws: [false; LAWS],
        })
        .collect())
}

/// Derivatives of the model's parameters at an instance by the instance's and the shared ones.
pub(super) struct ParameterSlopes {
    pub(super) by_own: SMatrix<f64, PARAMETERS, OWN>,
    pub(super) by_shared: SMatrix<f64, PARAMETERS, SHARED>,
}

impl ParameterSlopes {
    /// Returns whether a parameter of the model is fitted: whether it depends on any of the search.
    pub(super) fn is_fitted(&self, parameter: usize) -> bool {
        let (by_own, by_shared) = (self.by_own.row(parameter), self.by_shared.row(parameter));
        by_own.iter().chain(&by_shared).any(|slope| *slope != 0.0)
    }

    /// Returns the effect of calibration errors on the model's parameters, with the response of the fitted ones.
    pub(super) fn response(
        &self,
        covariance: &Covariance,
        instance: usize,
        by_error: &ByError<PARAMETERS>,
    ) -> ByError<PARAMETERS> {
        self.by_own * covariance.response.own[instance]
            + self.by_shared * covariance.response.shared
            + by_error
    }

    /// Returns the covariance of the model's parameters, including calibration errors that act on them by `by_error`.
    pub(super) fn covariance(
        &self,
        covariance: &Covariance,
        instance: usize,
        by_error: &ByError<PARAMETERS>,
    ) -> SMatrix<f64, PARAMETERS, PARAMETERS> {
        // θ = A o + B s + E c to first order, with calibration errors c of unit variance. The covariances of o and s include
        // their responses R_o, R_s to c. With R = A R_o + B R_s the terms with c are (R + E)(R + E)ᵀ = R Rᵀ + R Eᵀ + E Rᵀ +
        // E Eᵀ, of which R Rᵀ is in A C_oo Aᵀ + B C_ss Bᵀ + A C_os Bᵀ + B C_osᵀ Aᵀ already.
        let Self { by_own, by_shared } = self;
        let block = &covariance.blocks[instance];
        let cross = by_own * block.cross * by_shared.transpose();
        let response = self.response(covariance, instance, by_error) - by_error;
        let error_cross = response * by_error.transpose();
        by_own * block.own * by_own.transpose()
            + by_shared * covariance.shared * by_shared.transpose()
            + cross
            + cross.transpose()
            + error_cross
            + error_cross.transpose()
            + by_error * by_error.transpose()
    }
}
