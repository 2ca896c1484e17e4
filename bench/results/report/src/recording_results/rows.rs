//! Results of a recording, as in `recordings` of the results file: by the schema in RECORDING.md. Unknown values are null.

use protocols::Direction;
use recording::manifest::{RecordedAcross, RecordedRoom, StandardErrors};
use serde::Serialize;
use study::provenance::Provenance;

use analysis::force_zero::ZeroReading;
use recording::manifest::assumed_errors::AssumedErrors;

/// Lower and upper end.
pub type Interval = [f64; 2];

/// Real and imaginary part.
pub type Parts = [f64; 2];

/// Results of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recording {
    /// Folder, as given.
    pub path: String,
    /// Participant, as in [`analysis::RecordingAnalysis::participant`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// Whether its constants are those of the configuration instead of measured ones.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub uncalibrated: bool,
    /// Whether it is a calibrated measurement on a person; `None` if the recording cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// Carrier, Hz; `None` if the recording cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carrier_hz: Option<f64>,
    /// Whether `dynamic` corrects the amplitude under the finger by the recording's profile.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub plate_profile: bool,
    /// Wavelength across the plate, if the recording states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plate_across: Option<RecordedAcross>,
    /// Errors of the calibration as stated in the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_errors: Option<StandardErrors>,
    /// Standard errors assumed of the constants of which the recording neither states nor shows the error; 0 for the others.
    #[serde(skip_serializing_if = "AssumedErrors::is_empty")]
    pub assumed_errors: AssumedErrors,
    /// Room as stated in the recording; its pressure is p0 of every estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub room: Option<RecordedRoom>,
    /// Zero of the force sensor in each stretch without a finger, subtracted from the forces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub force_zero: Vec<ZeroReading>,
    /// Clock of the forces; `None` if it cannot be told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_clock: Option<ForceClockRow>,
    /// Corrected deviation of the pickup.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pickup_undone: Option<PickupUndone>,
    /// Impedance of the unloaded plate, N·s/m.
    pub z_p_n_s_per_m: Methods<Option<Parts>>,
    /// Friction of each exploration, in time order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub explorations: Vec<ExplorationRow>,
    /// Estimated instances, in time order.
    pub instances: Vec<Instance>,
    /// Parameters shared by the instances; `None` if their fit failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial: Option<Trial>,
    /// Self-sensed against measured normal force, by amplitude.
    pub model_check: Vec<BandRow>,
    /// Stretches without an estimate.
    pub rejected: Vec<RejectedRow>,
    /// Defects of the recording.
    pub warnings: Vec<String>,
}

/// Clock of the forces: t_drive = t_file + offset_s + ppm · 10⁻⁶ · (t_file − at_s).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceClockRow {
    /// Time at which the offset is stated, s.
    pub at_s: f64,
    /// Time from the first to the last slide, s.
    pub length_s: f64,
    /// Offset, s: negative if the forces come late.
    pub offset_s: f64,
    /// Excess of the rate of true times over the file's, parts per million.
    pub ppm: f64,
    /// Standard errors of both.
    pub std: ForceClockStd,
    /// Whether all other results have the offset corrected.
    pub offset_corrected: bool,
    /// Whether all other results have the rate corrected.
    pub rate_corrected: bool,
    /// Residual of the friction over further shifts of the forces, s.
    #[serde(skip)]
    pub residual: Vec<(f64, f64)>,
}

/// Standard errors of the clock of the forces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceClockStd {
    /// Standard error of the offset, s.
    pub offset_s: f64,
    /// Standard error of the rate, parts per million.
    pub ppm: f64,
}

/// Deviation of the pickup from its stated values, from the unloaded plate's response to the modulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PickupUndone {
    /// Phase, rad.
    pub phase_rad: f64,
    /// Delay, s.
    pub delay_s: f64,
}

/// A value by each method that estimates an instance separately.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Methods<T> {
    /// Value by the published method.
    pub paper: T,
    /// Value by the dynamic method.
    pub dynamic: T,
}

/// Instance with its estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Instance {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Direction of the exploration.
    pub direction: Direction,
    /// Mean normal force, N.
    pub normal_n: f64,
    /// Fall of |Z_m|, N·s/m.
    pub delta_z_m_n_s_per_m: f64,
    /// Fall of the measured friction.
    pub delta_mu: f64,
    /// Estimates of this instance alone.
    #[serde(flatten)]
    pub methods: Methods<Estimate>,
    /// Estimate together with the other instances; `None` if that fit failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial: Option<TrialEstimate>,
}

/// Parameters shared by the instances of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Apparent contact area S, m².
    pub contact_area_m2: f64,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: f64,
    /// Loss factor η.
    pub loss_factor: f64,
    /// Levitation lag τ, s.
    pub tau_s: f64,
    /// Exponent of S with the normal force.
    pub area_force_exponent: f64,
    /// Time over which the film averages, s; hardly determined.
    pub film_mean_s: f64,
    /// Exponent of τ with the gap.
    pub lag_gap_exponent: f64,
    /// Floor of friction as a fraction of μ0; `None` if the measured friction could not be fitted.
    pub friction_floor: Option<f64>,
    /// Lag of the lateral force, s; `None` if the measured friction could not be fitted.
    pub lateral_lag_s: Option<f64>,
    /// 95 % intervals, with the laws in doubt included; `None` if the model does not fit.
    pub interval95: Option<TrialIntervals>,
    /// 95 % intervals with the laws as published taken as true; `None` if these do not hold.
    pub interval95_within_laws: Option<TrialIntervals>,
    /// Number of instances.
    pub n_instances: usize,
    /// Verdict on the fit.
    pub verdict: String,
    /// Whether the model does not fit.
    pub model_misfit: bool,
    /// Signs of misfit, in words.
    pub misfit: Vec<String>,
    /// Signs that the laws as published do not hold, in words.
    pub misfit_within_laws: Vec<String>,
}

/// 95 % intervals of the shared parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as in `Trial`")]
pub struct TrialIntervals {
    pub contact_area_m2: Interval,
    pub q0_rad_per_m: Interval,
    pub loss_factor: Interval,
    pub tau_s: Interval,
    pub area_force_exponent: Interval,
    /// Null: a recording does not determine it.
    pub film_mean_s: (),
    pub lag_gap_exponent: Interval,
    pub friction_floor: Option<Interval>,
    pub lateral_lag_s: Option<Interval>,
}

/// Keys of `dynamic`, with intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrialEstimate {
    /// Estimate.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// 95 % intervals, with the laws in doubt included; `None` if the model does not fit.
    pub interval95: Option<InstanceIntervals>,
    /// 95 % intervals with the laws as published taken as true; `None` if these do not hold.
    pub interval95_within_laws: Option<InstanceIntervals>,
}

/// 95 % intervals of an instance's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as in `Estimate`")]
pub struct InstanceIntervals {
    pub sigma_t_m: Option<Interval>,
    pub z_t_re_n_s_per_m: Interval,
    pub z_t_im_n_s_per_m: Interval,
    pub mu0: Interval,
    pub resonance_shift_hz: Option<Interval>,
}

/// Estimate of an instance by a method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// σ_t, m; `None` if it is larger than any skin's.
    pub sigma_t_m: Option<f64>,
    /// Reason why it is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_t_null_because: Option<String>,
    /// Z_t, N·s/m.
    pub z_t_n_s_per_m: Parts,
    /// Levitation lag τ, s; `None` for `paper`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_s: Option<f64>,
    /// Offset of the plate's impedance since it was unloaded, N·s/m; `None` if it was not fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plate_offset_n_s_per_m: Option<Parts>,
    /// Shift of the plate's resonance by that offset, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance_shift_hz: Option<f64>,
    /// μ0.
    pub mu0: f64,
    /// R² of the impedance.
    pub r2_impedance: f64,
    /// RMS difference of the friction.
    pub rms_mu: f64,
    /// Spearman's coefficient of estimated and measured friction; `None` if either is constant.
    pub spearman_mu: Option<f64>,
    /// Fall of |Z_m| as used by the method, N·s/m.
    pub delta_z_m_n_s_per_m: f64,
    /// Fall of Re Z_m, N·s/m.
    pub delta_re_z_m_n_s_per_m: f64,
    /// Fall of |Im Z_m|, N·s/m.
    pub delta_abs_im_z_m_n_s_per_m: f64,
    /// Rise of the gap, m.
    pub delta_gap_m: f64,
    /// Rise of the reaction force's amplitude, N.
    pub delta_reaction_force_n: f64,
    /// Rise of the squeeze film's mean force, N.
    pub delta_squeeze_n: f64,
    /// Fall of the estimated friction.
    pub delta_mu: f64,
    /// Z_t of a rigid contact, N·s/m.
    pub rigid_z_t_n_s_per_m: Parts,
    /// Model with the participant's average σ_t.
    pub averaged: AveragedModel,
    /// Verdict on the fit.
    pub verdict: String,
    /// Whether the instance does not follow the method's laws; for `trial`, whether the model does not fit all instances.
    pub model_misfit: bool,
    /// Signs of misfit, in words.
    pub misfit: Vec<String>,
    /// Samples from which `paper` reads Z_t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_rest: Option<RestSamples>,
    /// Standard errors.
    pub std: Std,
    /// Sensitivities to the assumed constants; `None` if a refit near the assumed values fails.
    pub sensitivity: Option<SensitivityRows>,
}

/// Model with the participant's average σ_t.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AveragedModel {
    /// Average σ_t, m; `None` if no estimate of the participant by the method has a σ_t that a skin can have.
    pub sigma_t_m: Option<f64>,
    /// Reason why it is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_t_null_because: Option<String>,
    /// R² of the impedance.
    pub r2_impedance: f64,
}

/// Samples from which `paper` reads Z_t.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RestSamples {
    /// Whether their amplitudes count as rest; otherwise they are the lowest ones.
    pub below_threshold: bool,
    /// Number of samples.
    pub samples: usize,
    /// Largest amplitude, m.
    pub up_to_amplitude_m: f64,
}

/// Standard errors of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as in `Estimate`")]
pub struct Std {
    pub sigma_t_m: Option<f64>,
    pub z_t_n_s_per_m: Parts,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance_shift_hz: Option<f64>,
    pub mu0: f64,
}

/// Sensitivities ∂ln value/∂ln constant; for τ ∂τ/∂ln constant, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SensitivityRows {
    /// Sensitivities to q0 of the asperity law.
    pub sigma_q0_rad_per_m: SensitivityRow,
    /// Sensitivities to E.
    pub young_modulus_pa: SensitivityRow,
    /// Sensitivities to ν.
    pub poisson_ratio: SensitivityRow,
    /// Sensitivities to S.
    pub contact_area_m2: SensitivityRow,
}

/// Sensitivities to one constant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SensitivityRow {
    /// Sensitivity of σ_t.
    pub ln_sigma_t: f64,
    /// Sensitivity of |Z_t|.
    pub ln_abs_z_t: f64,
    /// Sensitivity of τ, s.
    pub tau_s: f64,
}

/// Difference of self-sensed and measured normal force at the amplitudes of one band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandRow {
    /// Smallest amplitude, m.
    pub amplitude_from_m: f64,
    /// Largest amplitude, m.
    pub amplitude_to_m: f64,
    /// Number of samples.
    pub n: usize,
    /// Median relative difference.
    pub force_relative_difference_median: f64,
    /// 90th percentile of the relative difference.
    pub force_relative_difference_p90: f64,
}

/// Stretch without an estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RejectedRow {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Direction of the exploration.
    pub direction: Direction,
    /// Reason of the rejection.
    pub reason: String,
    /// Kind of the reason, without its numbers.
    pub kind: String,
}

/// Friction of an exploration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExplorationRow {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Direction.
    pub direction: Direction,
    /// Number of samples with a friction.
    pub n: usize,
    /// Mean of the friction |lateral|/normal over them.
    pub mu: f64,
    /// Standard deviation of the friction over them.
    pub mu_scatter: f64,
    /// Mean normal force, N.
    pub normal_n: f64,
    /// Mean speed, m/s.
    pub speed_m_per_s: f64,
    /// Mean amplitude at the pickup, m.
    pub amplitude_m: f64,
    /// Effect of the stimulus, of which only forces were recorded; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stimulus: Option<StimulusRow>,
}

/// Effect of a stimulus on the friction of an exploration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StimulusRow {
    /// Friction at the least stimulus.
    pub mu_at_least: f64,
    /// Friction at the greatest stimulus.
    pub mu_at_greatest: f64,
    /// 1 − friction at the greatest over friction at the least stimulus.
    pub contrast: f64,
    /// Lag of the friction behind the stimulus, s.
    pub lag_s: f64,
    /// Share of the variance of the friction that the stimulus explains.
    pub r2: f64,
}
