//! Uncertainty of a calibration: errors of scale and phase that all samples of a recording share, so that no fit of the
//! samples can reveal them.
//!
//! The errors do not change the estimates. Their effect on each parameter is added to the parameters' covariance
//! ("considered", not fitted: Schmidt 1966).

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use crate::parameters::{FINGER_ANGLE, LN_FINGER, LN_FORCE, LN_RATIO, PARAMETERS};

/// Number of errors that act on the parameters of the impedance: four of the calibration, [`OTHER_MODES`] and [`LAWS`].
pub const ERRORS: usize = 6;

/// Effect of other modes of the plate on the film's amplitude, which no calibration states.
pub const OTHER_MODES: usize = 4;

/// Distance between a fit with the laws as published and one with laws in doubt, while the data do not reject the former.
pub const LAWS: usize = 5;

/// Effect of one standard deviation of each error on the parameters.
pub type ByError<const N: usize> = SMatrix<f64, N, ERRORS>;

/// Standard errors of the constants that turn volts into forces and amplitudes, and of the ambient pressure, independent of each
/// other; 0 means exact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CalibrationErrors {
    /// Relative standard error of the plate's amplitude: the pickup's sensitivity.
    pub amplitude_relative: f64,
    /// Relative standard error of Z_m: the ratio of the force factor to the pickup's sensitivity.
    pub impedance_relative: f64,
    /// Standard error of the phase of Z_m, rad.
    pub phase_rad: f64,
    /// Relative standard error of the normal force.
    pub normal_force_relative: f64,
    /// Relative standard error of the lateral force.
    pub lateral_force_relative: f64,
    /// Standard error of the lateral force per newton of normal force, from crosstalk between the axes.
    pub lateral_per_normal: f64,
    /// Relative standard error of the ambient pressure p0. Only p0 S and q0 S are measured, so that it acts on S and q0 alone, where
    /// these are fitted.
    pub ambient_pressure_relative: f64,
}

impl CalibrationErrors {
    /// Returns the errors of two independent sources together.
    #[must_use]
    pub fn sum(&self, other: &Self) -> Self {
        let Self {
            amplitude_relative,
            impedance_relative,
            phase_rad,
            normal_force_relative,
            lateral_force_relative,
            lateral_per_normal,
            ambient_pressure_relative,
        } = *other;
        Self {
            amplitude_relative: self.amplitude_relative.hypot(amplitude_relative),
            impedance_relative: self.impedance_relative.hypot(impedance_relative),
            phase_rad: self.phase_rad.hypot(phase_rad),
            normal_force_relative: self.normal_force_relative.hypot(normal_force_relative),
            lateral_force_relative: self.lateral_force_relative.hypot(lateral_force_relative),
            lateral_per_normal: self.lateral_per_normal.hypot(lateral_per_normal),
            ambient_pressure_relative: self
                .ambient_pressure_relative
                .hypot(ambient_pressure_relative),
        }
    }

    /// Returns the direct effect of each error on the parameters, before the fitted ones respond.
    pub fn by_parameter(&self) -> ByError<PARAMETERS> {
        let mut effect = ByError::zeros();
        effect[(LN_RATIO, 0)] = self.amplitude_relative;
        // The finger's part of Z_m goes with e^(2 ln φ + ε), φ the ratio of amplitudes and ε the error LN_FINGER. An error δ of
        // the amplitude alone leaves it as it is: δ ln φ = δ, ε = −2δ.
        effect[(LN_FINGER, 0)] = -2.0 * self.amplitude_relative;
        effect[(LN_FINGER, 1)] = self.impedance_relative;
        effect[(FINGER_ANGLE, 2)] = self.phase_rad;
        effect[(LN_FORCE, 3)] = self.normal_force_relative;
        effect
    }
}
