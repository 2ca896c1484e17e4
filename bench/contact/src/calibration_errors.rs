//! What a calibration leaves open: errors of scale and phase that all samples of a recording share, so that no fit of them
//! can see any.
//!
//! They move no estimate. What a parameter would do if a constant were another is carried into the parameters' covariance
//! ("considered", not fitted: Schmidt 1966).

use nalgebra::SMatrix;

use crate::parameters::{FINGER_ANGLE, LN_FINGER, LN_FORCE, LN_RATIO, PARAMETERS};

/// Number of errors that act on the parameters of the impedance: four of the calibration, and [`OF_OTHER_MODES`].
pub const ERRORS: usize = 5;

/// What other modes of the plate do to the film's amplitude, which no calibration states.
pub const OF_OTHER_MODES: usize = 4;

/// What each error, one standard deviation of it, does to parameters.
pub type ByError<const N: usize> = SMatrix<f64, N, ERRORS>;

/// Standard errors of the constants that turn volts into forces and amplitudes, each independent of the others; 0 is exact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CalibrationErrors {
    /// Of the plate's amplitude, relative: the pickup's sensitivity.
    pub amplitude_relative: f64,
    /// Of Z_m, relative: the force factor over the pickup's sensitivity.
    pub impedance_relative: f64,
    /// Of the phase of Z_m, rad.
    pub phase_rad: f64,
    /// Of the normal force, relative.
    pub normal_force_relative: f64,
    /// Of the lateral force, relative.
    pub lateral_force_relative: f64,
}

impl CalibrationErrors {
    /// Returns what each error does to the parameters where they act at once, before those that are fitted have followed.
    pub fn by_parameter(&self) -> ByError<PARAMETERS> {
        let mut by = ByError::zeros();
        by[(LN_RATIO, 0)] = self.amplitude_relative;
        // The ratio also scales the finger's part of Z_m, which an error of the amplitude alone does not.
        by[(LN_FINGER, 0)] = -2.0 * self.amplitude_relative;
        by[(LN_FINGER, 1)] = self.impedance_relative;
        by[(FINGER_ANGLE, 2)] = self.phase_rad;
        by[(LN_FORCE, 3)] = self.normal_force_relative;
        by
    }
}
