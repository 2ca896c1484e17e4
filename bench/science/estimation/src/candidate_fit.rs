//! Best Z_t and plate reactance for a given contact, without a search: the starting point of searches.

use num_complex::Complex64;

use super::lagged_model::{Finger, LaggedModel};
use contact::parameters::{IM_OFFSET, IM_Z_T, PARAMETERS, RE_OFFSET, RE_Z_T};

/// Number of iterations; each finds first the tissues and then the plate.
const ITERATIONS: usize = 4;

/// Tissues and plate that fit best with a candidate's contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct CandidateFit {
    /// Z_t, N·s/m.
    pub(super) z_t: Complex64,
    /// Reactance of the plate in addition to the candidate's, N·s/m.
    pub(super) reactance: f64,
    /// Mean square of the residuals of Z_m, weighted by their noise, N²·s²/m².
    pub(super) square: f64,
}

impl LaggedModel<'_> {
    /// Returns the best fit for a candidate, ignoring its Z_t; `None` where the model allows no such contact.
    ///
    /// Z_t and the plate's reactance are found in turn, each given the other: samples where the finger holds the plate
    /// determine Z_t, samples where the plate is nearly free determine its reactance.
    ///
    /// Noise of Z_m goes as 1/|ṽ_p|, so residuals r = Z_m − Z_p − iy − Z_t Z_c/(Z_t + Z_c) have the weight a², with the
    /// amplitude a at the film. A change δy of the reactance y turns Σ a²|r|² into Σ a²|r − i δy|², least at
    /// δy = Σ a² Im r/Σ a². `CandidateFit::square` is Σ a²|r|²/Σ a² before the last δy.
    pub(super) fn fit_candidate(&mut self, candidate: &[f64; PARAMETERS]) -> Option<CandidateFit> {
        let contact = self.follow_gap(candidate)?;
        let offset = Complex64::new(candidate[RE_OFFSET], candidate[IM_OFFSET]);
        let amplitudes = &self.loads.amplitude_m[self.lead..];
        let finger = self.finger(candidate, contact)?;
        let mut fit = CandidateFit {
            z_t: Complex64::ZERO,
            reactance: 0.0,
            square: f64::INFINITY,
        };
        for _ in 0..ITERATIONS {
            let z_p = self.z_p + offset + Complex64::I * fit.reactance;
            let (z_t, _) = self.tissue_given_gap(&finger, z_p);
            let (mut reactance_sum, mut square, mut weights) = (0.0, 0.0, 0.0);
            for (index, (z_m, amplitude_m)) in self.z_m.iter().zip(amplitudes).enumerate() {
                let residual = z_m - z_p - self.finger_with_tissue(&finger, z_t, self.lead + index);
                let weight = amplitude_m.powi(2);
                reactance_sum += weight * residual.im;
                square += weight * residual.norm_sqr();
                weights += weight;
            }
            fit.z_t = z_t;
            fit.square = square / weights;
            fit.reactance += reactance_sum / weights;
        }
        fit.square.is_finite().then_some(fit)
    }

    /// Returns the best-fitting candidate with its best Z_t; `None` where the model allows none of the candidates.
    ///
    /// Given the gap, 1/(Z_m − Z_p) = 1/Z_t + 1/Z_c is linear in 1/Z_t; its estimate is the mean weighted like the impedance
    /// residuals. The plate is taken as unloaded, and s = 1, Y = 0.
    pub(super) fn best_start(
        &mut self,
        candidates: impl IntoIterator<Item = [f64; PARAMETERS]>,
    ) -> Option<[f64; PARAMETERS]> {
        let mut best: Option<(f64, [f64; PARAMETERS])> = None;
        for mut parameters in candidates {
            let Some(contact) = self.follow_gap(&parameters) else {
                continue;
            };
            let Some(finger) = self.finger(&parameters, contact) else {
                continue;
            };
            let (z_t, squares) = self.tissue_given_gap(&finger, self.z_p);
            (parameters[RE_Z_T], parameters[IM_Z_T]) = (z_t.re, z_t.im);
            if z_t.is_finite() && best.is_none_or(|(min_squares, _)| squares < min_squares) {
                best = Some((squares, parameters));
            }
        }
        best.map(|(_, parameters)| parameters)
    }

    /// Returns the best Z_t for the gap computed by [`follow`](Self::follow), and the weighted sum of squared residuals.
    fn tissue_given_gap(&self, contact: &Finger, z_p: Complex64) -> (Complex64, f64) {
        let (mut sum, mut squares, mut weights) = (Complex64::ZERO, 0.0, 0.0);
        for (index, &z_m) in self.z_m.iter().enumerate() {
            let finger = z_m - z_p;
            // m = 1/(Z_m − Z_p) − 1/Z_c is one reading of 1/Z_t. An error δm is one of −(Z_m − Z_p)² δm in Z_m, so
            // Σ|Z_m − Ẑ_m|² ≈ Σ w |m − 1/Z_t|² with w = |Z_m − Z_p|⁴. Minimum: 1/Z_t = Σ w m/Σ w, and there
            // Σ w |m|² − |Σ w m|²/Σ w.
            let weight = finger.norm_sqr().powi(2);
            if weight > 0.0 {
                let tissue_mobility = self.tissue_mobility(contact, finger, self.lead + index);
                sum += weight * tissue_mobility;
                squares += weight * tissue_mobility.norm_sqr();
                weights += weight;
            }
        }
        (weights / sum, squares - sum.norm_sqr() / weights)
    }
}
