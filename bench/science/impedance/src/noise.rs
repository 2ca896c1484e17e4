//! Noise of a channel around the carrier.

use crate::filter::{Filter, PROBE_PAIRS};
use crate::kernel;

/// Number of frames per noise estimate: as long as the filter, so that estimates are nearly independent.
const FRAMES_PER_LOOK: u64 = 10;
const AVERAGING_S: f64 = 0.5;

/// Running estimate of the noise on an envelope, from narrow bands next to the carrier that no envelope reaches.
#[derive(Clone, Debug)]
pub(crate) struct NoiseFloor {
    /// Average power above and below the carrier at each probe's offset, as the equivalent variance of an envelope's
    /// quadrature.
    variance: [[f64; 2]; PROBE_PAIRS],
    looks: u64,
    /// Number of estimates in the average.
    memory: f64,
    frames: u64,
    quadrature_std: f64,
}

impl NoiseFloor {
    pub(crate) fn new(filter: &Filter) -> Self {
        let looks_per_s = filter.output_rate_hz() / FRAMES_PER_LOOK as f64;
        Self {
            variance: [[0.0; 2]; PROBE_PAIRS],
            looks: 0,
            memory: AVERAGING_S * looks_per_s,
            frames: 0,
            quadrature_std: f64::INFINITY,
        }
    }

    /// Adds the window of a frame without flaws.
    pub(crate) fn observe(&mut self, filter: &Filter, re: &[f64], im: &[f64]) {
        self.frames += 1;
        if self.frames % FRAMES_PER_LOOK != 1 {
            return;
        }
        self.looks += 1;
        // A plain mean until the memory is full, then an exponential mean.
        let weight = 1.0 / (self.looks as f64).min(self.memory);
        let second = &filter.second;
        for ((variance, probe), gain) in self
            .variance
            .iter_mut()
            .zip(&second.probes)
            .zip(second.probe_gain)
        {
            let taps = probe.each_ref().map(Vec::as_slice);
            let [[rr, ri], [ir, ii]] = kernel::inner_products([re, im], taps);
            // z = re + i im, p = p_r + i p_i: |Σ z p|² at +Δ and |Σ z p*|² at −Δ, with rr = Σ re p_r, ri = Σ re p_i, and so on.
            let upper = (rr - ii).powi(2) + (ri + ir).powi(2);
            let lower = (rr + ii).powi(2) + (ir - ri).powi(2);
            for (variance, power) in variance.iter_mut().zip([upper, lower]) {
                *variance += weight * (gain * power - *variance);
            }
        }
        let mut sorted = self.variance;
        let sorted = sorted.as_flattened_mut();
        sorted.sort_unstable_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        self.quadrature_std = ((sorted[middle - 1] + sorted[middle]) / 2.0).sqrt();
    }

    /// Returns the standard deviation of one quadrature of the envelope; infinite before the first estimate.
    pub(crate) fn quadrature_std(&self) -> f64 {
        self.quadrature_std
    }
}
