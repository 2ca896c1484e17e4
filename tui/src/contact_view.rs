//! Estimates of the finger's contact: the fit of a trial, the last modulation period, or why they are missing.

use crate::action::AttemptName;
use crate::impedance_value::{ComplexImpedance, ValueAndStd};

/// Result of a trial's fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitView {
    /// Number of the trial.
    pub trial: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// σ_t, m.
    pub sigma_t_m: Option<ValueAndStd>,
    /// Friction coefficient without vibration.
    pub mu0: Option<ValueAndStd>,
    /// Drift of the plate's resonance after the trial, Hz.
    pub drift_hz: Option<ValueAndStd>,
    /// Why the fit is missing.
    pub no_fit: Option<String>,
    /// Results of the fit in words, a line each.
    pub details: Vec<String>,
    /// The fitted contact as curves.
    pub curves: Option<ContactCurves>,
}

impl FitView {
    /// Returns the name of the attempt.
    #[must_use]
    pub fn name(&self) -> AttemptName {
        AttemptName {
            trial: self.trial,
            practice: self.practice,
            attempt: self.attempt,
        }
    }
}

/// A fitted contact as curves over the vibration amplitude.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactCurves {
    /// Normal force of the curves, N.
    pub normal_n: f64,
    /// Fitted impedance of the plate.
    pub z_p_n_s_per_m: ComplexImpedance,
    /// Z_m, from small to large amplitudes.
    pub locus: Vec<ComplexImpedance>,
    /// Amplitude, m, and fitted friction coefficient.
    pub friction: Vec<(f64, f64)>,
    /// Amplitude, m, and friction coefficient measured in the trial's instances, as medians of equal parts.
    pub measured: Vec<(f64, f64)>,
}

/// The impedance over the last period of the modulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PeriodTrace {
    /// Corrected Z_m, evenly spaced in time; `None` where masked.
    pub z_m_n_s_per_m: Vec<Option<ComplexImpedance>>,
    /// The plain ratio, at the same times.
    pub z_plain_n_s_per_m: Vec<Option<ComplexImpedance>>,
    /// Length of the period, s.
    pub duration_s: f64,
}

impl PeriodTrace {
    /// Returns the masked fraction of the period, 0 to 1.
    #[must_use]
    pub fn masked(&self) -> f64 {
        let masked_count = self.z_m_n_s_per_m.iter().filter(|z| z.is_none()).count();
        masked_count as f64 / self.z_m_n_s_per_m.len().max(1) as f64
    }
}

/// Why gap and friction are not estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoEstimate {
    /// No trial was fitted yet.
    NoFit,
    /// No finger is on the plate.
    NoFinger,
    /// The normal force is not measured.
    NoForce,
    /// The impedance is masked.
    Masked,
    /// The measurement is outside the range of the model.
    OffModel,
}
