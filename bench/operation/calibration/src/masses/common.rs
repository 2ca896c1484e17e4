//! Constants shared by the steps of a force calibration.

use calibration_rig::operator::ForceAxis;

/// Axes in the order of readings.
pub(super) const AXES: [ForceAxis; 2] = [ForceAxis::Normal, ForceAxis::Lateral];
/// Number of windows at rest averaged for the first zero.
pub(super) const TARE_WINDOWS: usize = 3;
/// Smallest standard deviation of a reading, N: the last digit of a sensor that sends whole micronewtons.
pub(super) const LEAST_SIGMA_N: f64 = 1e-6;
