//! Best Z_t and plate reactance for a given contact, without a search: the starting point of searches.

use num_complex::Complex64;

use super::lagged_model::LaggedModel;
use contact::parameters::{IM_OFFSET, PARAMETERS, RE_OFFSET};

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
        let z_c: Vec<Complex64> = (self.gap[self.lead..].iter().zip(amplitudes).enumerate())
            .map(|(index, (&gap, &amplitude))| {
                let contact = self.contact_at(&contact, self.lead + index);
                let stiffness = contact.stiffness_n_per_m(gap, amplitude);
                contact.impedance_n_s_per_m(stiffness, self.carrier_rad_per_s)
            })
            .collect();
        let mut fit = CandidateFit {
            z_t: Complex64::ZERO,
            reactance: 0.0,
            square: f64::INFINITY,
        };
        for _ in 0..ITERATIONS {
            let z_p = self.z_p + offset + Complex64::I * fit.reactance;
            let (z_t, _) = self.tissue_given_gap(&contact, z_p);
            let (mut reactance_sum, mut square, mut weights) = (0.0, 0.0, 0.0);
            for ((z_m, z_c), amplitude_m) in self.z_m.iter().zip(&z_c).zip(amplitudes) {
                let residual = z_m - z_p - z_t * z_c / (z_t + z_c);
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
}
