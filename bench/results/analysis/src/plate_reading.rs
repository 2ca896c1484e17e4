//! Z_p of the unloaded plate.

use impedance::{Mask, ZmFrame};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::method::Method;

/// Impedance Z_p of the unloaded plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlateReading {
    /// Mean of the plain ratio, as published, N·s/m.
    pub plain_n_s_per_m: Complex64,
    /// Corrected impedance at the middle of the frames' times, with each frame weighted by its precision, N·s/m.
    pub corrected_n_s_per_m: Complex64,
    /// Number of frames used.
    pub frames: usize,
}

/// Fewest frames for a reading of the plate: 50 ms at 2 kHz.
pub const FEWEST_PLATE_FRAMES: usize = 100;

/// Reads Z_p from the frames of the unloaded intervals; `None` with fewer than [`FEWEST_PLATE_FRAMES`] usable
/// ones. The corrected impedance is taken from a straight line in time at its middle: a weighted mean would favour the times of
/// large amplitude, where a drifting plate has another impedance.
pub fn plate<'a>(unloaded_frames: impl IntoIterator<Item = &'a ZmFrame>) -> Option<PlateReading> {
    let usable_frames = unloaded_frames
        .into_iter()
        .filter(|frame| frame.mask == Mask::CLEAR);
    let frames: Vec<(&ZmFrame, f64)> = usable_frames
        .map(|frame| {
            let weight = frame.corrected_std_n_s_per_m.powi(-2);
            // Without noise, as in synthetic recordings, all frames have the same weight.
            (frame, if weight.is_finite() { weight } else { 1.0 })
        })
        .collect();
    if frames.len() < FEWEST_PLATE_FRAMES {
        return None;
    }
    let n = frames.len() as f64;
    let plain = frames.iter().map(|(frame, _)| frame.plain_n_s_per_m);
    let middle_s = frames.iter().map(|(frame, _)| frame.time_s).sum::<f64>() / n;
    let weights: f64 = frames.iter().map(|(_, weight)| weight).sum();
    let weighted_mean = |value: &dyn Fn(&ZmFrame) -> Complex64| {
        let terms = frames.iter().map(|(frame, weight)| value(frame) * weight);
        terms.sum::<Complex64>() / weights
    };
    // Z(t) = Z̄ + b (t − t̄) with b = Σw (t − t̄)(Z − Z̄)/Σw (t − t̄)² and w = 1/σ², read at the plain mean of the times.
    let mean = weighted_mean(&|frame| frame.corrected_n_s_per_m);
    let mean_s = weighted_mean(&|frame| frame.time_s.into()).re;
    let covariance =
        weighted_mean(&|frame| (frame.time_s - mean_s) * (frame.corrected_n_s_per_m - mean));
    let variance = weighted_mean(&|frame| (frame.time_s - mean_s).powi(2).into()).re;
    let rate_per_s = if variance > 0.0 {
        covariance / variance
    } else {
        Complex64::ZERO
    };
    Some(PlateReading {
        plain_n_s_per_m: plain.sum::<Complex64>() / n,
        corrected_n_s_per_m: mean + rate_per_s * (middle_s - mean_s),
        frames: frames.len(),
    })
}

impl PlateReading {
    /// Returns Z_p as used by a method, N·s/m.
    pub fn z_p(&self, method: Method) -> Complex64 {
        match method {
            Method::Paper => self.plain_n_s_per_m,
            Method::Dynamic | Method::Trial => self.corrected_n_s_per_m,
        }
    }
}
