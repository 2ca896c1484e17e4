//! Constants that the steps of a force calibration share.

use calibration::operator::ForceAxis;

/// Axes in the order of readings.
pub(super) const AXES: [ForceAxis; 2] = [ForceAxis::Normal, ForceAxis::Lateral];
/// Number of windows at rest that the first zero is averaged over.
pub(super) const TARE_WINDOWS: usize = 3;
/// Smallest standard deviation of a reading, N: the last digit of a sensor that sends micronewtons.
pub(super) const LEAST_SIGMA_N: f64 = 1e-6;
