//! Parameters of an instance, parameters shared by a trial's instances, and the model's parameters as a function of both.
//!
//! With an instance's own parameters o, the shared s, and its place u in units of 30 mm, the model's parameters θ are
//!
//! ```text
//! τ = e^(s_τ),  T = e^(s_T)                        the other parameters as they are
//! Δ = o_Δ + mean + Σ_k s_k by_course_k             plate: its predicted course, and deviations from it (`plate.rs`)
//! φ = o_φ + s_φ,  y_r = o_y + s_y                  other modes, at this place and at all
//! ln r = s_tilt u + s_bow u²                       amplitude along the plate
//! ```

use std::ops::{Add, Mul};

use crate::arrowhead::{ArrowCovariance, ArrowMinimum, ParameterPoint};
use nalgebra::{SMatrix, SVector};

use super::plate::{COURSES, OffsetPrior};
use crate::lagged_model::LaggedModel;
use contact::calibration_errors::{ByError, ERRORS};
use contact::parameters::{
    AREA_EXPONENT, FILM_MEAN_MS, FINGER_ANGLE, IM_OFFSET, IM_Z_T, LAG_EXPONENT, LN_AREA,
    LN_LOSS_FACTOR, LN_Q0, LN_RATIO, LN_SIGMA_T, MS, PARAMETERS, RE_OFFSET, RE_Z_T,
    RESIDUAL_MOBILITY, TAU_MS,
};

/// Number of parameters per instance.
pub(super) const OWN: usize = 7;
/// Number of parameters that all instances share.
pub(super) const SHARED: usize = 16;

pub(super) type Own = SVector<f64, OWN>;
pub(super) type Shared = SVector<f64, SHARED>;
pub(super) type TrialMinimum = ArrowMinimum<OWN, SHARED>;
pub(super) type Step = ParameterPoint<OWN, SHARED>;
pub(super) type Covariance = ArrowCovariance<OWN, SHARED, ERRORS>;

/// Model parameters of one instance, in the order of a block.
pub(super) const INSTANCE_PARAMETERS: [usize; OWN] = [
    LN_SIGMA_T,
    RE_Z_T,
    IM_Z_T,
    IM_OFFSET,
    RE_OFFSET,
    FINGER_ANGLE,
    RESIDUAL_MOBILITY,
];
pub(super) const SIGMA_T: usize = 0;
pub(super) const TISSUE: [usize; 2] = [1, 2];
pub(super) const REACTANCE: usize = 3;
pub(super) const DAMPING: usize = 4;
pub(super) const ANGLE: usize = 5;
pub(super) const RESIDUAL: usize = 6;

/// Model parameters shared by the trial, in the arrow's order, followed by [`COURSE`] and the two of the amplitude along the
/// plate. Times are stored as their logarithms.
pub(super) const TRIAL_PARAMETERS: [usize; SHARED - COURSES - 4] = [
    LN_AREA,
    LN_Q0,
    LN_LOSS_FACTOR,
    TAU_MS,
    AREA_EXPONENT,
    FILM_MEAN_MS,
    LAG_EXPONENT,
];
pub(super) const AREA: usize = 0;
pub(super) const Q0: usize = 1;
pub(super) const LOSS_FACTOR: usize = 2;
pub(super) const TAU: usize = 3;
pub(super) const GROWTH: usize = 4;
pub(super) const FILM_MEAN: usize = 5;
pub(super) const LAG_GROWTH: usize = 6;
/// Index of the first of the [`COURSES`], deviations of the plate from its likely course in standard deviations.
pub(super) const COURSE: usize = 7;
/// Logarithm of the ratio of the amplitude along the plate to that at the pickup: its growth over [`TILT_DISTANCE_M`], and its
/// increase at that distance on both sides.
pub(super) const TILT: usize = COURSE + COURSES;
pub(super) const BOW: usize = TILT + 1;
/// Effect of other modes that is common to all instances: angle and residual mobility.
pub(super) const COMMON_ANGLE: usize = BOW + 1;
pub(super) const COMMON_RESIDUAL: usize = COMMON_ANGLE + 1;
/// Distance along the plate at which tilt and bow are stated, m: half of the published central part.
pub(super) const TILT_DISTANCE_M: f64 = 0.03;

/// Times stored as their logarithms, paired with the model's parameters in ms.
const TIMES_MS: [(usize, usize); 2] = [(TAU, TAU_MS), (FILM_MEAN, FILM_MEAN_MS)];

/// An instance of a trial.
pub(super) struct Member<'a> {
    pub(super) model: LaggedModel<'a>,
    /// Prior of the plate's offset.
    pub(super) offset: OffsetPrior,
    /// Distance from the plate's centre, in units of [`TILT_DISTANCE_M`].
    pub(super) position: f64,
}

impl Member<'_> {
    /// Returns the model's parameters.
    pub(super) fn parameters(&self, shared: &Shared, own: &Own) -> [f64; PARAMETERS] {
        let mut parameters = [0.0; PARAMETERS];
        for (value, parameter) in own.iter().zip(INSTANCE_PARAMETERS) {
            parameters[parameter] = *value;
        }
        for (value, parameter) in shared.iter().zip(TRIAL_PARAMETERS) {
            parameters[parameter] = *value;
        }
        for (index, parameter) in TIMES_MS {
            parameters[parameter] = shared[index].exp() / MS;
        }
        let offset = self.offset.value(courses(shared));
        parameters[RE_OFFSET] += offset.re;
        parameters[IM_OFFSET] += offset.im;
        parameters[FINGER_ANGLE] += shared[COMMON_ANGLE];
        parameters[RESIDUAL_MOBILITY] += shared[COMMON_RESIDUAL];
        parameters[LN_RATIO] = shared[TILT] * self.position + shared[BOW] * self.position.powi(2);
        parameters
    }

    /// Returns the slopes by the parameters that all instances share, from the slopes by the model's parameters.
    pub(super) fn by_shared<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>>(
        &self,
        slopes: &[T; PARAMETERS],
        parameters: &[f64; PARAMETERS],
    ) -> [T; SHARED] {
        // ∂/∂s = Σ (∂/∂θ)(∂θ/∂s); of a time, ∂θ/∂ ln θ = θ.
        std::array::from_fn(|index| match TRIAL_PARAMETERS.get(index) {
            Some(&parameter) if is_time(parameter) => slopes[parameter] * parameters[parameter],
            Some(&parameter) => slopes[parameter],
            None => self
                .dependents(index)
                .into_iter()
                .fold(T::default(), |sum, (parameter, slope)| {
                    sum + slopes[parameter] * slope
                }),
        })
    }

    /// Returns the model's parameters that depend on one of the last shared ones, with the slopes.
    fn dependents(&self, index: usize) -> [(usize, f64); 2] {
        let (parameter, slope) = match index {
            TILT => (LN_RATIO, self.position),
            BOW => (LN_RATIO, self.position.powi(2)),
            COMMON_ANGLE => (FINGER_ANGLE, 1.0),
            COMMON_RESIDUAL => (RESIDUAL_MOBILITY, 1.0),
            _ => {
                let slope = self.offset.by_course[index - COURSE];
                return [(RE_OFFSET, slope.re), (IM_OFFSET, slope.im)];
            }
        };
        [(parameter, slope), (parameter, 0.0)]
    }

    /// Returns the derivatives of the model's parameters by those of the instance and those of the trial.
    pub(super) fn parameter_slopes(&self, parameters: &[f64; PARAMETERS]) -> ParameterSlopes {
        let mut by_own = SMatrix::zeros();
        for (column, parameter) in INSTANCE_PARAMETERS.into_iter().enumerate() {
            by_own[(parameter, column)] = 1.0;
        }
        let mut by_shared = SMatrix::zeros();
        for (column, parameter) in TRIAL_PARAMETERS.into_iter().enumerate() {
            let unit = if is_time(parameter) {
                parameters[parameter]
            } else {
                1.0
            };
            by_shared[(parameter, column)] = unit;
        }
        for column in COURSE..SHARED {
            for (parameter, slope) in self.dependents(column) {
                by_shared[(parameter, column)] += slope;
            }
        }
        ParameterSlopes { by_own, by_shared }
    }
}

/// Derivatives of the model's parameters at an instance by the instance's and the shared ones.
pub(super) struct ParameterSlopes {
    pub(super) by_own: SMatrix<f64, PARAMETERS, OWN>,
    pub(super) by_shared: SMatrix<f64, PARAMETERS, SHARED>,
}

impl ParameterSlopes {
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

/// Returns the coefficient of each course.
pub(super) fn courses(shared: &Shared) -> &[f64] {
    &shared.as_slice()[COURSE..TILT]
}

fn is_time(parameter: usize) -> bool {
    TIMES_MS.iter().any(|(_, time)| *time == parameter)
}
