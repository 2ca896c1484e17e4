//! Parameters of the search and their places in its vectors.
//!
//! Each kind of parameter is an enum that indexes the vectors of its kind alone: `own[InstanceParameter::LnSigmaT]`,
//! `shared[SharedParameter::LnArea]`.

use std::ops::{Index, IndexMut};

use nalgebra::SVector;

use super::plate::COURSES;
use contact::parameters::{
    FINGER_ANGLE, IM_OFFSET, IM_Z_T, LN_SIGMA_T, RE_OFFSET, RE_Z_T, RESIDUAL_MOBILITY,
};

/// Number of parameters per instance.
pub(super) const OWN: usize = 7;
/// Number of parameters that all instances share.
pub(super) const SHARED: usize = 11 + COURSES;

pub(super) type Own = SVector<f64, OWN>;
pub(super) type Shared = SVector<f64, SHARED>;

/// Parameter of one instance, in the order of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InstanceParameter {
    LnSigmaT,
    ReZT,
    ImZT,
    /// Offset of the plate's reactance.
    Reactance,
    /// Offset of the plate's damping.
    Damping,
    /// Angle of other modes at this place.
    Angle,
    /// Residual mobility of other modes at this place.
    ResidualMobility,
}

impl InstanceParameter {
    pub(super) const ALL: [Self; OWN] = [
        Self::LnSigmaT,
        Self::ReZT,
        Self::ImZT,
        Self::Reactance,
        Self::Damping,
        Self::Angle,
        Self::ResidualMobility,
    ];

    /// Returns the index of the parameter in the model's order.
    pub(super) fn model_index(self) -> usize {
        match self {
            Self::LnSigmaT => LN_SIGMA_T,
            Self::ReZT => RE_Z_T,
            Self::ImZT => IM_Z_T,
            Self::Reactance => IM_OFFSET,
            Self::Damping => RE_OFFSET,
            Self::Angle => FINGER_ANGLE,
            Self::ResidualMobility => RESIDUAL_MOBILITY,
        }
    }
}

/// Parameter that all instances of a trial share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SharedParameter {
    LnArea,
    LnQ0,
    LnLossFactor,
    /// Logarithm of τ in s.
    LnTau,
    AreaExponent,
    /// Logarithm of the film's averaging time in s.
    LnFilmMean,
    LagExponent,
    /// One of the [`COURSES`], a deviation of the plate from its likely course in standard deviations.
    Course(usize),
    /// Logarithm of the ratio of the amplitude along the plate to that at the pickup: its growth over
    /// [`TILT_DISTANCE_M`](super::members::TILT_DISTANCE_M).
    Tilt,
    /// Increase of that logarithm at the same distance on both sides.
    Bow,
    /// Angle of other modes that is common to all instances.
    Angle,
    /// Residual mobility of other modes that is common to all instances.
    ResidualMobility,
}

impl SharedParameter {
    /// All, in the arrow's order.
    pub(super) const ALL: [Self; SHARED] = [
        Self::LnArea,
        Self::LnQ0,
        Self::LnLossFactor,
        Self::LnTau,
        Self::AreaExponent,
        Self::LnFilmMean,
        Self::LagExponent,
        Self::Course(0),
        Self::Course(1),
        Self::Course(2),
        Self::Course(3),
        Self::Course(4),
        Self::Tilt,
        Self::Bow,
        Self::Angle,
        Self::ResidualMobility,
    ];

    /// Returns the parameter's place in a vector of shared ones.
    pub(super) fn position(self) -> usize {
        let position = Self::ALL.iter().position(|parameter| *parameter == self);
        position.expect("all courses are among the parameters")
    }
}

/// Returns the coefficient of each course.
pub(super) fn courses(shared: &Shared) -> &[f64] {
    let start = SharedParameter::Course(0).position();
    &shared.as_slice()[start..start + COURSES]
}

impl Index<InstanceParameter> for Own {
    type Output = f64;

    fn index(&self, parameter: InstanceParameter) -> &f64 {
        &self[parameter as usize]
    }
}

impl IndexMut<InstanceParameter> for Own {
    fn index_mut(&mut self, parameter: InstanceParameter) -> &mut f64 {
        &mut self[parameter as usize]
    }
}

impl Index<SharedParameter> for Shared {
    type Output = f64;

    fn index(&self, parameter: SharedParameter) -> &f64 {
        &self[parameter.position()]
    }
}

impl IndexMut<SharedParameter> for Shared {
    fn index_mut(&mut self, parameter: SharedParameter) -> &mut f64 {
        &mut self[parameter.position()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_instance_parameters_are_in_order() {
        for (position, parameter) in InstanceParameter::ALL.into_iter().enumerate() {
            assert_eq!(parameter as usize, position);
        }
    }
}
