//! Parameters of the search and their places in its vectors.
//!
//! Each kind of parameter is an enum that indexes the vectors of its kind alone: `own[InstanceParameter::LnSigmaT]`,
//! `shared[SharedParameter::LnArea]`.

use std::ops::{Index, IndexMut};

use nalgebra::SVector;

use contact::parameters::{
    CYCLE_AVERAGE, FILM_LOSS, FINGER_ANGLE, IM_OFFSET, IM_Z_T, LN_SIGMA_T, RE_OFFSET, RE_Z_T,
    RELATIVE_SHARE, RESIDUAL_MOBILITY, SOFTENING, TRAPPED_SHARE, WIDTH_SQUARE,
};

/// Number of parameters per instance.
pub(super) const OWN: usize = 7;
/// Number of joint deviations of the plate's offsets from their likely course.
pub(super) const COURSES: usize = 5;
/// Number of parameters that all instances share with the laws as published.
pub(super) const PUBLISHED: usize = 11 + COURSES;
/// Number of parameters of the laws in doubt.
pub(super) const LAWS: usize = 6;
/// Number of parameters that all instances share.
pub(super) const SHARED: usize = PUBLISHED + LAWS;

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
    /// One of the laws in doubt.
    Law(Law),
}

/// Law in doubt, in the order of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Law {
    /// Loss factor of the film less that of the asperities.
    FilmLoss,
    /// Share of trapped air.
    TrappedAir,
    /// Share of the skin's motion that the film follows.
    RelativeMotion,
    /// Exponent of the average of the asperities' force over a cycle.
    CycleAverage,
    /// Change of the plate's reactance with its squared amplitude, N·s/m per µm².
    Softening,
    /// Square of the contact's width across the plate: in units of the square of the mode's wavelength, or of 4S/π where the
    /// wavelength is known.
    Width,
}

impl Law {
    pub(super) const ALL: [Self; LAWS] = [
        Self::FilmLoss,
        Self::TrappedAir,
        Self::RelativeMotion,
        Self::CycleAverage,
        Self::Softening,
        Self::Width,
    ];

    /// Returns the index of the parameter in the model's order.
    pub(super) fn model_index(self) -> usize {
        match self {
            Self::FilmLoss => FILM_LOSS,
            Self::TrappedAir => TRAPPED_SHARE,
            Self::RelativeMotion => RELATIVE_SHARE,
            Self::CycleAverage => CYCLE_AVERAGE,
            Self::Softening => SOFTENING,
            Self::Width => WIDTH_SQUARE,
        }
    }
}

/// Laws in doubt that a fit leaves free.
pub(super) type FreeLaws = [bool; LAWS];

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
        Self::Law(Law::FilmLoss),
        Self::Law(Law::TrappedAir),
        Self::Law(Law::RelativeMotion),
        Self::Law(Law::CycleAverage),
        Self::Law(Law::Softening),
        Self::Law(Law::Width),
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
