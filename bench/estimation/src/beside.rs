//! Finds tissues and plate beside a given contact, without a search: where searches begin.

use num_complex::Complex64;

use super::lagged_model::LaggedModel;
use contact::parameters::{IM_OFFSET, PARAMETERS, RE_OFFSET};

/// Times that tissues and plate are found in turn.
const TURNS: usize = 4;

/// Tissues and plate that go best with a candidate's contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    /// Z_t, N·s/m.
    pub(super) z_t: Complex64,
    /// Reactance of the plate beside the candidate's, N·s/m.
    pub(super) reactance: f64,
    /// Mean square of what is left of Z_m, weighted as noise has it, N²·s²/m².
    pub(super) square: f64,
}

impl LaggedModel<'_> {
    /// Returns what goes best with a candidate, whose own Z_t does not matter; `None` where the model allows no such contact.
    ///
    /// Z_t and the plate's reactance are found in turn, each given the other: Z_t shows where the finger holds the plate, the
    /// plate where it is nearly let go.
    pub(super) fn beside(&mut self, candidate: &[f64; PARAMETERS]) -> Option<Beside> {
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
        let mut found = Beside {
            z_t: Complex64::ZERO,
            reactance: 0.0,
            square: f64::INFINITY,
        };
        for _ in 0..TURNS {
            let z_p = self.z_p + offset + Complex64::I * found.reactance;
            let (z_t, _) = self.tissue_given_gap(&contact, z_p);
            let (mut off, mut square, mut weights) = (0.0, 0.0, 0.0);
            for ((z_m, z_c), amplitude_m) in self.z_m.iter().zip(&z_c).zip(amplitudes) {
                let left = z_m - z_p - z_t * z_c / (z_t + z_c);
                let weight = amplitude_m.powi(2);
                off += weight * left.im;
                square += weight * left.norm_sqr();
                weights += weight;
            }
            found.z_t = z_t;
            found.square = square / weights;
            found.reactance += off / weights;
        }
        found.square.is_finite().then_some(found)
    }
}
