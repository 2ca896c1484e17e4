//! Limits of a calibration's results, and its period of validity.

use serde::{Deserialize, Serialize};

use super::refusal::{Refused, require_range};
use crate::correction::MOST_CROSSTALK;

/// `[calibration]`: limits on the results of a calibration, and the time for which it is valid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct CalibrationRules {
    /// Present gain settings of amplifiers and inputs, in words; a calibration is valid only for these settings.
    pub gains: String,
    /// Age beyond which a calibration is refused, days.
    pub max_age_days: f64,
    /// Largest plate amplitude that a calibration may request, m.
    pub max_amplitude_m: f64,
    /// Largest residual of the pickup's points about a line, as a share of the largest amplitude.
    pub pickup_nonlinearity: f64,
    /// Largest relative standard error of the pickup's sensitivity.
    pub pickup_error: f64,
    /// Largest root mean square residual of the plate's response about its fit, as a share of its peak. Real plates leave 1 to 4 %;
    /// their effect on the constants is limited by `plate_error`.
    pub plate_residual: f64,
    /// Largest standard error of the plate's constants by the fit: of Q and of the static response relative, of the resonance
    /// in half bandwidths. It includes scatter, narrower bands and a second mode.
    pub plate_error: f64,
    /// Lowest and highest quality factor of the untouched plate.
    pub quality: [f64; 2],
    /// Largest change of the resonance since the previous calibration, Hz.
    pub drift_hz: f64,
    /// Relative standard error of the sample clock of the sound card, in whose hertz a resonance is measured, ppm. The default
    /// covers cards without a stated accuracy (an assumption of this project).
    pub clock_ppm: f64,
    /// Largest reading of a force sensor without load, N.
    pub zero_n: f64,
    /// Acceleration of gravity at the bench, m/s²; if absent, standard gravity (9.80665) with an error that covers any place at
    /// sea level. National geodetic services give the local value (for most places to 1e-5 by latitude and height, GRS 80).
    pub gravity_m_per_s2: Option<f64>,
    /// Scatter of means over a tenth of a second below which a force reading counts as at rest, N; scatter explained by the
    /// sensor's noise is also allowed.
    pub force_rest_n: f64,
    /// Largest residual of a known mass under the fitted matrix, as a share of the largest force on its axis.
    pub force_nonlinearity: f64,
    /// Largest relative standard error of the force sensor's sensitivity on either axis.
    pub force_error: f64,
    /// Largest crosstalk between the axes of the force sensor, N per newton read.
    pub force_crosstalk: f64,
    /// Largest noise of either axis, N/√Hz.
    pub force_noise_n_per_sqrt_hz: f64,
    /// Largest drift of the zero of either axis, N/min.
    pub force_drift_n_per_min: f64,
    /// Largest residual of the zero of either axis about its drift after a load was removed, N.
    pub force_zero_return_n: f64,
    /// Largest noise density of an input about the carrier, sample units per √Hz.
    pub input_noise_units_per_sqrt_hz: f64,
    /// Largest crosstalk of the drive into another input, dB.
    pub crosstalk_db: f64,
    /// Largest residual of an input's levels about a line, as a share of the largest level.
    pub input_nonlinearity: f64,
    /// Largest delay between an input and the drive's input, samples.
    pub delay_samples: f64,
    /// Largest relative standard error of an input's gain, and of its phase in rad.
    pub input_error: f64,
    /// Largest relative difference between the bench's volts and those of an independent meter.
    pub meter_tolerance: f64,
    /// Age beyond which a check of the volts against a meter is no longer valid, days.
    pub meter_max_age_days: f64,
}

impl Default for CalibrationRules {
    fn default() -> Self {
        Self {
            gains: String::new(),
            max_age_days: 30.0,
            max_amplitude_m: 5e-6,
            pickup_nonlinearity: 0.01,
            pickup_error: 0.01,
            plate_residual: 0.1,
            plate_error: 0.1,
            quality: [50.0, 2000.0],
            drift_hz: 100.0,
            clock_ppm: 50.0,
            zero_n: 0.05,
            gravity_m_per_s2: None,
            force_rest_n: 3e-4,
            force_nonlinearity: 0.01,
            force_error: 0.02,
            force_crosstalk: 0.2,
            force_noise_n_per_sqrt_hz: 1e-3,
            force_drift_n_per_min: 0.02,
            force_zero_return_n: 0.01,
            input_noise_units_per_sqrt_hz: 1e-6,
            crosstalk_db: -60.0,
            input_nonlinearity: 0.005,
            delay_samples: 8.0,
            input_error: 1e-3,
            meter_tolerance: 0.03,
            meter_max_age_days: 365.0,
        }
    }
}

/// Lowest and highest acceleration of gravity on earth, m/s²: on a mountain at the equator, and at the poles.
pub const GRAVITY: [f64; 2] = [9.76, 9.84];

impl CalibrationRules {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let require_range = |key: &str, value: f64, low: f64, high: f64, unit: &str| {
            require_range(&format!("calibration.{key}"), value, low, high, unit)
        };
        require_range("max_age_days", self.max_age_days, 0.01, 3650.0, "days")?;
        require_range("max_amplitude_m", self.max_amplitude_m, 1e-8, 2e-5, "m")?;
        require_range(
            "pickup_nonlinearity",
            self.pickup_nonlinearity,
            1e-4,
            0.2,
            "",
        )?;
        require_range("pickup_error", self.pickup_error, 1e-4, 0.2, "")?;
        require_range("plate_residual", self.plate_residual, 1e-5, 0.2, "")?;
        require_range("plate_error", self.plate_error, 1e-4, 0.3, "")?;
        require_range("quality", self.quality[0], 1.0, self.quality[1], "")?;
        require_range("drift_hz", self.drift_hz, 0.1, 5e3, "Hz")?;
        require_range("clock_ppm", self.clock_ppm, 0.0, 1e3, "ppm")?;
        require_range("zero_n", self.zero_n, 1e-3, 1.0, "N")?;
        if let Some(gravity) = self.gravity_m_per_s2 {
            require_range("gravity_m_per_s2", gravity, GRAVITY[0], GRAVITY[1], "m/s²")?;
        }
        require_range("force_rest_n", self.force_rest_n, 1e-6, 0.05, "N")?;
        require_range("force_nonlinearity", self.force_nonlinearity, 1e-4, 0.2, "")?;
        require_range("force_error", self.force_error, 1e-4, 0.2, "")?;
        require_range(
            "force_crosstalk",
            self.force_crosstalk,
            1e-3,
            MOST_CROSSTALK,
            "N/N",
        )?;
        require_range(
            "force_noise_n_per_sqrt_hz",
            self.force_noise_n_per_sqrt_hz,
            1e-7,
            0.1,
            "N/√Hz",
        )?;
        require_range(
            "force_drift_n_per_min",
            self.force_drift_n_per_min,
            1e-5,
            1.0,
            "N/min",
        )?;
        require_range(
            "force_zero_return_n",
            self.force_zero_return_n,
            1e-5,
            1.0,
            "N",
        )?;
        require_range(
            "input_noise_units_per_sqrt_hz",
            self.input_noise_units_per_sqrt_hz,
            1e-10,
            1e-3,
            "/√Hz",
        )?;
        require_range("crosstalk_db", self.crosstalk_db, -160.0, -10.0, "dB")?;
        require_range("input_nonlinearity", self.input_nonlinearity, 1e-5, 0.2, "")?;
        require_range("delay_samples", self.delay_samples, 0.01, 200.0, "samples")?;
        require_range("input_error", self.input_error, 1e-7, 0.1, "")?;
        require_range("meter_tolerance", self.meter_tolerance, 1e-3, 0.1, "")?;
        let days = self.meter_max_age_days;
        require_range("meter_max_age_days", days, 0.01, 3650.0, "days")
    }
}
