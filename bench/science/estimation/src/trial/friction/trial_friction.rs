//! Friction of a trial: the shared parameters and μ0 of each instance, with their errors.

use nalgebra::{Matrix2, SMatrix, SVector};

use super::parameters::FRICTION_PARAMETERS;
use crate::friction_law::{Course, FrictionLaw};
use contact::parameters::PARAMETERS;
use contact::uncertain::Uncertain;

/// Friction of a trial.
pub(crate) struct TrialFriction {
    /// Parameters that all instances share.
    pub(crate) shared: SharedFriction,
    /// Friction at rest of each instance.
    pub(crate) instances: Vec<RestFriction>,
}

/// Parameters of friction that all instances of a trial share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedFriction {
    /// φ.
    pub(crate) floor: Uncertain,
    /// Lag of the lateral force, s.
    pub(crate) lag_s: Uncertain,
}

/// μ0 of an instance, with its variances and derivatives.
pub(crate) struct RestFriction {
    /// μ0 at the middle of the instance.
    pub(crate) mu0: f64,
    /// Change of μ0 within the instance.
    pub(crate) course: Course,
    /// Variance of μ0 from the scatter of the measured friction, with φ and the lag held fixed and no random walk of μ0.
    pub(super) mu0_variance: f64,
    /// Covariance of μ0 and φ from the scatter of the measured friction.
    pub(crate) scatter: Matrix2<f64>,
    /// Derivatives of μ0 by φ and the lag.
    pub(crate) by_trial: SVector<f64, FRICTION_PARAMETERS>,
    /// Derivatives of μ0 by the instance's contact, with φ and the lag held fixed.
    pub(crate) by_contact: SVector<f64, PARAMETERS>,
    /// Derivatives of φ and the lag by the instance's contact.
    pub(crate) trial_by_contact: SMatrix<f64, FRICTION_PARAMETERS, PARAMETERS>,
}

impl TrialFriction {
    /// Returns an instance's friction law for an exactly known contact.
    pub(crate) fn law(&self, index: usize) -> FrictionLaw<PARAMETERS> {
        let instance = &self.instances[index];
        FrictionLaw {
            mu0: instance.mu0,
            course: instance.course,
            floor: self.shared.floor.value,
            lag_s: self.shared.lag_s.value,
            slopes: instance.by_contact.into(),
            floor_slopes: [0.0; PARAMETERS],
            scatter: instance.scatter,
        }
    }
}
