//! Time series of an exploration.

use num_complex::Complex64;
use protocols::Validity;
use serde::{Deserialize, Serialize};

use crate::measurements::{ForceSeries, FrameSeries};
use crate::method::Method;
use crate::under_finger::UnderFinger;

/// All measurements during an exploration, at the times of the impedance frames.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ExplorationSeries {
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
    /// Stimulus of a surface of which only forces were recorded; NaN in other recordings, and without a stimulus.
    pub stimulus: Vec<f64>,
}

impl ExplorationSeries {
    /// Makes the series of an exploration with an impedance.
    pub fn new(series: FrameSeries, under_finger: UnderFinger) -> Self {
        let mu = friction(&series.lateral_n, &series.normal_n);
        let plain = series.frames.iter().map(|frame| frame.plain_n_s_per_m);
        Self {
            mu,
            z_m_plain_n_s_per_m: plain.collect(),
            stimulus: vec![f64::NAN; series.time_s.len()],
            under_finger,
            time_s: series.time_s,
            amplitude_m: series.amplitude_m,
            normal_n: series.normal_n,
            lateral_n: series.lateral_n,
            position_m: series.position_m,
            velocity_m_per_s: series.velocity_m_per_s,
            validity: series.validity,
        }
    }

    /// Makes the series of a slide of which only forces were recorded, at the times of their rows.
    pub(crate) fn from_forces(series: ForceSeries) -> Self {
        let n = series.time_s.len();
        let unknown = vec![f64::NAN; n];
        let unknown_z_m = vec![Complex64::new(f64::NAN, f64::NAN); n];
        Self {
            mu: friction(&series.lateral_n, &series.normal_n),
            z_m_plain_n_s_per_m: unknown_z_m.clone(),
            under_finger: UnderFinger {
                ratio: unknown.clone(),
                amplitude_m: unknown.clone(),
                z_m_n_s_per_m: unknown_z_m,
            },
            time_s: series.time_s,
            amplitude_m: unknown,
            normal_n: series.normal_n,
            lateral_n: series.lateral_n,
            position_m: series.position_m,
            velocity_m_per_s: series.velocity_m_per_s,
            validity: vec![Validity::LostSamples; n],
            stimulus: series.stimulus,
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

/// Returns |f_t|/f_n; NaN where the body does not press.
fn friction(lateral_n: &[f64], normal_n: &[f64]) -> Vec<f64> {
    let pairs = lateral_n.iter().zip(normal_n);
    pairs
        .map(|(lateral, normal)| {
            if *normal > 0.0 {
                lateral.abs() / normal
            } else {
                f64::NAN
            }
        })
        .collect()
}
