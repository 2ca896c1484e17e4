//! Limits on the constants of a plate, measured on the bench or elsewhere.

use crate::rejected_result::RejectedResult;
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
    pub(crate) fn faults(&self, limits: &CalibrationRules) -> Vec<RejectedResult> {
        let ConstantErrors {
            resonance,
            quality: quality_error,
            static_ratio,
        } = self.errors;
        let mut faults = Vec::new();
        if self.residual > limits.plate_residual {
            faults.push(RejectedResult::PlateResidual {
                residual: self.residual,
                limit: limits.plate_residual,
            });
        }
        if self.errors.largest() > limits.plate_error {
            faults.push(RejectedResult::PlateUncertain {
                resonance,
                quality: quality_error,
                static_ratio,
                limit: limits.plate_error,
            });
        }
        let [low, high] = limits.quality;
        if !(low..=high).contains(&self.quality) {
            faults.push(RejectedResult::PlateQuality {
                quality: self.quality,
                low,
                high,
            });
        }
        if let Some(drift_hz) = self.drift_hz
            && drift_hz.abs() > limits.drift_hz
        {
            faults.push(RejectedResult::PlateMoved {
                drift_hz,
                limit_hz: limits.drift_hz,
            });
        }
        faults
    }
}
