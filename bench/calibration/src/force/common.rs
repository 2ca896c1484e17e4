//! What the steps of a force calibration share.

use crate::operator::ForceAxis;

pub(super) const AXES: [ForceAxis; 2] = [ForceAxis::Normal, ForceAxis::Lateral];
/// Windows at rest that make the first zero.
pub(super) const TARE_WINDOWS: usize = 3;
/// Deviation that no reading undercuts, N: the last digit of a sensor that sends micronewtons.
pub(super) const LEAST_SIGMA_N: f64 = 1e-6;
