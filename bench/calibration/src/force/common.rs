//! What the steps of a force calibration share.

use crate::operator::Axis;

pub(super) const AXES: [Axis; 2] = [Axis::Normal, Axis::Lateral];
/// Windows at rest that make the first zero.
pub(super) const TARE_WINDOWS: usize = 3;
/// Deviation that no reading undercuts, N: the last digit of a sensor that sends micronewtons.
pub(super) const LEAST_SIGMA_N: f64 = 1e-6;
