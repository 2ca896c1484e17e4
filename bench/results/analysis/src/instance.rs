//! Prepares an instance of an exploration for the fits, and the plate's impedance that they subtract.

use std::ops::Range;

use contact::AssumedConstants;
use estimation::trial::PlacedInstance;
use estimation::{FitConditions, FitError, InstanceSamples, InstanceSeries, ModeAcross};
use impedance::ZmFrame;
use impedance::smoothing::LowPass;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::error_budget::ErrorBudget;
use crate::measurements::{FrameSeries, SMOOTHING_HZ};
use crate::method::Method;
use crate::plate_reading::PlateReading;
use crate::under_finger::UnderFinger;

/// Time before an instance from which a fit may use samples, s; the levitation lag forgets its initial value within 20 ms of
/// it.
pub const LEAD_IN_S: f64 = 0.025;

/// Samples of an instance and of its lead-in, at the frames' rate; the accessors return only those of the instance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreparedInstance {
    time_s: Vec<f64>,
    plain_n_s_per_m: Vec<Complex64>,
    amplitude_m: Vec<f64>,
    under_finger: UnderFinger,
    normal_n: Vec<f64>,
    finger_force_n: Vec<f64>,
    mu: Vec<f64>,
    position_m: f64,
    start: usize,
}

impl PreparedInstance {
    /// Extracts the instance from `start_s` to `end_s` from its exploration, with the frames `under_finger`. The plain
    /// impedance is smoothed as published, at 100 Hz with zero phase, over the unmasked frames about the instance; the
    /// corrected one is not smoothed.
    ///
    /// μ is |f_t|/f_n of the smoothed forces.
    pub fn cut(
        series: &FrameSeries,
        under_finger: &UnderFinger,
        (start_s, end_s): (f64, f64),
    ) -> Self {
        // Times that passed through text have errors below this.
        let slack_s = 1e-6;
        let first = series.time_s.partition_point(|&t| t < start_s - slack_s);
        let end = series
            .time_s
            .partition_point(|&t| t <= end_s + slack_s)
            .max(first);
        let lead_in_start = series
            .time_s
            .partition_point(|&t| t < start_s - LEAD_IN_S - slack_s);
        let range = lead_in_start..end;
        Self {
            time_s: series.time_s[range.clone()].to_vec(),
            plain_n_s_per_m: smooth_plain_impedance(&series.frames, first..end)[range.clone()]
                .to_vec(),
            amplitude_m: series.amplitude_m[range.clone()].to_vec(),
            under_finger: under_finger.slice(range.clone()),
            normal_n: series.normal_n[range.clone()].to_vec(),
            finger_force_n: series.finger_force_n[range.clone()].to_vec(),
            mu: range
                .map(|i| (series.lateral_n[i] / series.normal_n[i]).abs())
                .collect(),
            position_m: series.position_m[first..end].iter().sum::<f64>() / (end - first) as f64,
            start: first - lead_in_start,
        }
    }

    /// Returns the instance for the fit of a trial, on a plate with its centre at `centre_m`.
    ///
    /// # Errors
    /// Same as [`series`](Self::series).
    pub fn placement(&self, centre_m: f64) -> Result<PlacedInstance<'_>, FitError> {
        Ok(PlacedInstance {
            series: self.series(Method::Dynamic)?,
            off_centre_m: self.position_m - centre_m,
        })
    }

    /// Returns the samples for the fit of a method, with its lead-in.
    ///
    /// # Errors
    /// A sample is missing or out of its range.
    pub fn series(&self, method: Method) -> Result<InstanceSeries<'_>, FitError> {
        let samples = InstanceSamples {
            time_s: &self.time_s,
            z_m_plain_n_s_per_m: &self.plain_n_s_per_m,
            z_m_corrected_n_s_per_m: &self.under_finger.z_m_n_s_per_m,
            amplitude_m: self.amplitudes_m(method),
            normal_n: match method {
                Method::Paper => &self.normal_n,
                Method::Dynamic | Method::Trial => &self.finger_force_n,
            },
            mu: &self.mu,
        };
        InstanceSeries::new(samples, self.start)
    }

    /// Returns the times, s.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s[self.start..]
    }

    /// Returns the amplitude used by a method, peak, m: |x̃_p| for `paper`, that under the finger for `dynamic`.
    pub fn amplitude_m(&self, method: Method) -> &[f64] {
        &self.amplitudes_m(method)[self.start..]
    }

    /// Returns the ratio of the amplitude used by a method to |x̃_p|: 1 for `paper`.
    pub fn amplitude_ratio(&self, method: Method, sample: usize) -> f64 {
        match method {
            Method::Paper => 1.0,
            Method::Dynamic | Method::Trial => self.under_finger.ratio[self.start + sample],
        }
    }

    /// Returns the normal force, N.
    pub fn normal_n(&self) -> &[f64] {
        &self.normal_n[self.start..]
    }

    /// Returns the normal force without its sensor's noise, N, as used by `dynamic` and `trial`.
    pub fn finger_force_n(&self) -> &[f64] {
        &self.finger_force_n[self.start..]
    }

    /// Returns the measured friction.
    pub fn mu(&self) -> &[f64] {
        &self.mu[self.start..]
    }

    /// Returns the impedance used by a method, N·s/m: plain and smoothed for `paper`, corrected for
    /// envelope dynamics and under the finger for `dynamic`.
    pub fn z_m(&self, method: Method) -> &[Complex64] {
        let z_m = match method {
            Method::Paper => &self.plain_n_s_per_m,
            Method::Dynamic | Method::Trial => &self.under_finger.z_m_n_s_per_m,
        };
        &z_m[self.start..]
    }

    fn amplitudes_m(&self, method: Method) -> &[f64] {
        match method {
            Method::Paper => &self.amplitude_m,
            Method::Dynamic | Method::Trial => &self.under_finger.amplitude_m,
        }
    }
}

/// Returns the plain impedance of all frames, smoothed over the run of unmasked frames that contains `instance`.
fn smooth_plain_impedance(frames: &[ZmFrame], instance: Range<usize>) -> Vec<Complex64> {
    let mut plain: Vec<Complex64> = frames.iter().map(|frame| frame.plain_n_s_per_m).collect();
    let is_usable = |frame: &ZmFrame| frame.mask.is_clear();
    let leading_frames = frames[..instance.start]
        .iter()
        .rev()
        .take_while(|f| is_usable(f));
    let start = instance.start - leading_frames.count();
    let trailing_frames = frames[instance.end..].iter().take_while(|f| is_usable(f));
    let end = instance.end + trailing_frames.count();
    let run = start..end;
    if run.len() < 2 {
        return plain;
    }
    let rate_hz = (run.len() - 1) as f64 / (frames[end - 1].time_s - frames[start].time_s);
    // A run that is too short or incomplete is left unchanged; the fit reports the sample that it cannot use.
    if let Ok(smooth) = LowPass::new(SMOOTHING_HZ, rate_hz)
        .and_then(|filter| filter.zero_phase(&plain[run.clone()]))
    {
        plain[run].copy_from_slice(&smooth);
    }
    plain
}

impl PlateReading {
    /// Returns the conditions shared by all fits of the recording, with the errors of its constants, and the mode across its plate if
    /// that is known.
    pub fn conditions(
        &self,
        assumed: AssumedConstants,
        carrier_hz: f64,
        errors: &ErrorBudget,
        mode_across: Option<ModeAcross>,
    ) -> FitConditions {
        FitConditions {
            assumed,
            carrier_hz,
            z_p_plain_n_s_per_m: self.plain_n_s_per_m,
            z_p_corrected_n_s_per_m: self.corrected_n_s_per_m,
            calibration: errors.known,
            assumed_errors: errors.assumed,
            mode_across,
        }
    }
}
