//! Time series of an exploration.

use num_complex::Complex64;
use protocols::{Direction, Stretch, Validity};

use crate::measurements::FrameSeries;
use crate::method::Method;
use crate::under_finger::UnderFinger;

/// All measurements during an exploration, at the times of the impedance frames, and the stretches selected from them.
#[derive(Debug, Clone)]
pub struct ExplorationFindings {
    /// Direction of the slide.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Drive voltage across the actuators at the peaks of the modulation, V; NaN without frames.
    pub drive_peak_v: f64,
    /// Times of the frames, s, evenly spaced.
    pub time_s: Vec<f64>,
    /// |x̃_p|, peak, m; NaN where samples were lost.
    pub amplitude_m: Vec<f64>,
    /// Amplitude and impedance under the finger, as used by `dynamic`; NaN where they could not be read.
    pub under_finger: UnderFinger,
    /// Normal force, low-passed at 100 Hz with zero phase, N.
    pub normal_n: Vec<f64>,
    /// Lateral force, low-passed at 100 Hz with zero phase, N.
    pub lateral_n: Vec<f64>,
    /// Measured friction |f_t|/f_n; NaN where the finger does not press.
    pub mu: Vec<f64>,
    /// Finger position, m.
    pub position_m: Vec<f64>,
    /// Finger velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// f̃_a/ṽ_p, N·s/m; NaN where it could not be read.
    pub z_m_plain_n_s_per_m: Vec<Complex64>,
    /// Whether amplitude and impedance could be read.
    pub validity: Vec<Validity>,
    /// Stretches of rising amplitude, each with its instance or the reason for its rejection.
    pub stretches: Vec<Stretch>,
}

impl ExplorationFindings {
    /// Makes the findings from the series between `start_s` and `end_s`, and its selected `stretches`.
    pub fn new(
        series: FrameSeries,
        under_finger: UnderFinger,
        direction: Direction,
        (start_s, end_s): (f64, f64),
        stretches: Vec<Stretch>,
    ) -> Self {
        let mu = series
            .lateral_n
            .iter()
            .zip(&series.normal_n)
            .map(|(lateral, normal)| {
                if *normal > 0.0 {
                    lateral.abs() / normal
                } else {
                    f64::NAN
                }
            })
            .collect();
        let plain = series.frames.iter().map(|frame| frame.plain_n_s_per_m);
        Self {
            direction,
            start_s,
            end_s,
            drive_peak_v: drive_peak_v(&series),
            mu,
            z_m_plain_n_s_per_m: plain.collect(),
            under_finger,
            time_s: series.time_s,
            amplitude_m: series.amplitude_m,
            normal_n: series.normal_n,
            lateral_n: series.lateral_n,
            position_m: series.position_m,
            velocity_m_per_s: series.velocity_m_per_s,
            validity: series.validity,
            stretches,
        }
    }

    /// Returns the impedance used by a method, N·s/m; for `paper` before its filter.
    pub fn z_m(&self, method: Method) -> &[Complex64] {
        match method {
            Method::Paper => &self.z_m_plain_n_s_per_m,
            Method::Dynamic | Method::Trial => &self.under_finger.z_m_n_s_per_m,
        }
    }

    /// Returns the amplitude used by a method, peak, m: |x̃_p| for `paper`, that under the finger for `dynamic`.
    pub fn method_amplitude_m(&self, method: Method) -> &[f64] {
        match method {
            Method::Paper => &self.amplitude_m,
            Method::Dynamic | Method::Trial => &self.under_finger.amplitude_m,
        }
    }

    /// Returns the time from one frame to the next, s; `None` with fewer than two frames.
    pub fn interval_s(&self) -> Option<f64> {
        let n = self.time_s.len();
        (n > 1).then(|| (self.time_s[n - 1] - self.time_s[0]) / (n - 1) as f64)
    }
}

/// Share of the frames with a smaller drive than its peak: the modulation is within 0.2 % of its peak for the rest, and a single
/// disturbed frame has no effect.
const BELOW_PEAK: f64 = 0.98;

fn drive_peak_v(series: &FrameSeries) -> f64 {
    let drive_v = series.frames.iter().map(|frame| frame.drive_v.norm());
    let mut drive_v: Vec<f64> = drive_v.filter(|volts| volts.is_finite()).collect();
    drive_v.sort_by(f64::total_cmp);
    statistics::quantile(&drive_v, BELOW_PEAK).unwrap_or(f64::NAN)
}
