//! Samples that the fit of a trial's friction takes.

use crate::lagged_model::GAP_PARAMETERS;

/// Samples of a trial for the fit of its friction.
pub(crate) struct TrialSamples<'a> {
    pub(crate) instances: Vec<RatioSamples<'a>>,
    /// Sampling interval of every instance, s.
    pub(crate) interval_s: f64,
}

/// Samples of one instance for the fit of a trial's friction.
pub(crate) struct RatioSamples<'a> {
    /// Modelled friction ratio, with the lead-in.
    pub(crate) ratio: Vec<f64>,
    /// Normal force, with the lead-in, N.
    pub(crate) normal_n: &'a [f64],
    /// Number of samples of lead-in.
    pub(crate) lead: usize,
    /// Measured friction of the instance, without the lead-in.
    pub(crate) mu: &'a [f64],
    /// ∂`ratio`/∂parameter, for the parameters in [`GAP_PARAMETERS`].
    pub(crate) ratio_slopes: [Vec<f64>; GAP_PARAMETERS.len()],
    /// Time, with the lead-in, s.
    pub(crate) time_s: &'a [f64],
    /// Time at the middle of the instance, s.
    pub(crate) middle_s: f64,
}
