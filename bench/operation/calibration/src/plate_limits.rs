//! Limits on the constants of a plate, whatever they were measured with.

use config::CalibrationRules;
use metrology::plate_fit::ConstantErrors;

/// Results of a plate's fit that have limits.
pub(crate) struct FitResults {
    /// Root mean square residual, of the largest response.
    pub(crate) residual: f64,
    /// Errors of the constants by the fit.
    pub(crate) errors: ConstantErrors,
    /// Quality factor.
    pub(crate) quality: f64,
    /// Change of the resonance since the previous calibration, Hz.
    pub(crate) drift_hz: Option<f64>,
}

impl FitResults {
    /// Returns the reasons to reject the fit, by `limits`.
    pub(crate) fn faults(&self, limits: &CalibrationRules) -> Vec<String> {
        let ConstantErrors {
            resonance,
            quality: quality_error,
            static_ratio,
        } = self.errors;
        let mut faults = Vec::new();
        if self.residual > limits.plate_residual {
            faults.push(format!(
                "the response departs from a resonance by {:.2} % of its peak, more than calibration.plate_residual = {}: check that nothing touches the plate and that its clamp is tight",
                100.0 * self.residual,
                limits.plate_residual
            ));
        }
        if self.errors.largest() > limits.plate_error {
            faults.push(format!(
                "the fit leaves errors of {:.2} half bandwidths in the resonance, {:.1} % in Q and {:.1} % in the static response, more than calibration.plate_error = {}: check the plate's clamp and neighbouring modes, and measure with less noise or in finer steps",
                resonance,
                100.0 * quality_error,
                100.0 * static_ratio,
                limits.plate_error
            ));
        }
        let [low, high] = limits.quality;
        if !(low..=high).contains(&self.quality) {
            faults.push(format!(
                "Q = {:.1} is outside calibration.quality = [{low}, {high}]: a finger or a loose clamp damps the plate",
                self.quality
            ));
        }
        if let Some(drift_hz) = self.drift_hz
            && drift_hz.abs() > limits.drift_hz
        {
            faults.push(format!(
                "the resonance has moved by {drift_hz:+.1} Hz since the last calibration, more than calibration.drift_hz = {}: check the plate, its clamp and the temperature",
                limits.drift_hz
            ));
        }
        faults
    }
}
