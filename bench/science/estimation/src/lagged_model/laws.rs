//! Laws in doubt: what each adds to the impedance of a sample.
//!
//! Huloux 2021, Eqs. 14–18 may not be the laws of a finger. Six parameters, all 0 for the published laws, describe others:
//!
//! ```text
//! η_f = η + δ                      loss factor of film and trapped air
//! α                                share of trapped air (`contact::stiffness`)
//! ρ, ι                             relative motion, average over the cycle (`loads.rs`)
//! Z_p + i ς a_p²                   resonance that falls with the plate's amplitude a_p
//! κ = (w/λ)²                       width w of the contact across a mode m(y) = cos(2πy/λ)
//! ```
//!
//! Over its width the contact is a row of springs at the velocities m(y) ṽ of the plate. The skin moves as one, at ṽ_t. Asperities
//! and trapped air are alike at all y, U in sum; the film's stiffness goes with the square of the local amplitude,
//! F m²/⟨m²⟩. The force on the skin is Z_t ṽ_t, the one on the mode is weighted by m(y):
//!
//! ```text
//! Z_t ṽ_t = Q ṽ − (U + F) ṽ_t,       Q = U ⟨m⟩ + F ⟨m³⟩/⟨m²⟩
//! Z_f ṽ   = P ṽ − Q ṽ_t,             P = U ⟨m²⟩ + F ⟨m⁴⟩/⟨m²⟩
//! Z_f = P − r Q,                     r = ṽ_t/ṽ = Q/(Z_t + U + F)
//! ∂Z_f/∂U = ⟨m²⟩ − 2r ⟨m⟩ + r²,      ∂Z_f/∂F = (⟨m⁴⟩ − 2r ⟨m³⟩)/⟨m²⟩ + r²,      ∂Z_f/∂Z_t = r²
//! ```
//!
//! Without width all means are 1 and Z_f is that of Eq. 9.

use num_complex::Complex64;

use super::model::LaggedModel;
use contact::StiffnessParts;
use contact::inversion::Inversion;
use contact::mode_moments::ModeMoments;
use contact::parameters::{
    FILM_LOSS, IM_Z_T, LN_LOSS_FACTOR, PARAMETERS, RE_Z_T, SOFTENING, WIDTH_SQUARE,
};

/// Laws that a model follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Laws {
    /// As published; the parameters of other laws are ignored.
    Published,
    /// With the parameters of the laws in doubt.
    InDoubt,
}

/// Parameters of the laws in doubt that act on a sample's impedance at a given stiffness.
#[derive(Clone, Copy)]
pub(super) struct DoubtfulFinger {
    /// (η − i)/ω and (η + δ − i)/ω, s.
    asperities: Complex64,
    film: Complex64,
    /// ⟨m⟩, ⟨m²⟩, ⟨m³⟩/⟨m²⟩, ⟨m⁴⟩/⟨m²⟩, and their derivatives by κ.
    means: [f64; 4],
    slopes: [f64; 4],
    carrier_rad_per_s: f64,
    loss_factor: f64,
}

/// Contact of finite width and skin at a sample.
#[derive(Clone, Copy)]
pub(super) struct WideContact {
    /// U, F and Q.
    uniform: Complex64,
    film: Complex64,
    onto_skin: Complex64,
    /// ṽ_t/ṽ.
    skin_ratio: Complex64,
    pub(super) z_finger: Complex64,
}

/// Derivatives of Z_f at a sample.
#[derive(Clone, Copy)]
pub(super) struct WideSlopes {
    /// By the stiffness of asperities, film and trapped air, s.
    pub(super) by_part: [Complex64; 3],
    pub(super) by_z_t: Complex64,
    pub(super) by_ln_loss_factor: Complex64,
    pub(super) by_film_loss: Complex64,
    /// By κ at constant stiffness.
    pub(super) by_width_square: Complex64,
}

impl DoubtfulFinger {
    pub(super) fn new(parameters: &[f64; PARAMETERS], carrier_rad_per_s: f64) -> Option<Self> {
        let ModeMoments { means, slopes } = ModeMoments::new(parameters[WIDTH_SQUARE])?;
        let [mean, square, cube, fourth] = means;
        // (u/v)′ = (u′ − (u/v) v′)/v.
        let ratio_slope =
            |power: usize| (slopes[power] - means[power] / square * slopes[1]) / square;
        let loss_factor = parameters[LN_LOSS_FACTOR].exp();
        let per_stiffness =
            |loss_factor: f64| Complex64::new(loss_factor, -1.0) / carrier_rad_per_s;
        Some(Self {
            asperities: per_stiffness(loss_factor),
            film: per_stiffness(loss_factor + parameters[FILM_LOSS]),
            means: [mean, square, cube / square, fourth / square],
            slopes: [slopes[0], slopes[1], ratio_slope(2), ratio_slope(3)],
            carrier_rad_per_s,
            loss_factor,
        })
    }

    /// Returns the contact of given stiffness on tissues.
    pub(super) fn contact(&self, parts: &StiffnessParts, z_t: Complex64) -> WideContact {
        let [mean, square, cube, fourth] = self.means;
        let uniform = self.asperities * parts.asperities + self.film * parts.trapped;
        let film = self.film * parts.film;
        let onto_skin = uniform * mean + film * cube;
        let skin_ratio = onto_skin / (z_t + uniform + film);
        WideContact {
            uniform,
            film,
            onto_skin,
            skin_ratio,
            z_finger: uniform * square + film * fourth - skin_ratio * onto_skin,
        }
    }

    /// Returns 1/Z_t for a contact of given stiffness and the finger's part of Z_m.
    pub(crate) fn tissue_mobility(&self, parts: &StiffnessParts, finger: Complex64) -> Complex64 {
        let [_, square, _, fourth] = self.means;
        let contact = self.contact(parts, Complex64::ONE);
        let (uniform, film, onto_skin) = (contact.uniform, contact.film, contact.onto_skin);
        // Z_f = P − Q²/(Z_t + U + F) solved for Z_t.
        let weighted = uniform * square + film * fourth;
        (onto_skin * onto_skin / (weighted - finger) - uniform - film).inv()
    }

    pub(super) fn slopes(&self, contact: &WideContact, parts: &StiffnessParts) -> WideSlopes {
        let [mean, square, cube, fourth] = self.means;
        let [mean_slope, square_slope, cube_slope, fourth_slope] = self.slopes;
        let r = contact.skin_ratio;
        let by_uniform = square - 2.0 * mean * r + r * r;
        let by_film = fourth - 2.0 * cube * r + r * r;
        // Of Z_c = (η − i) k_r/ω + (η + δ − i)(k_f + k_a)/ω.
        let (uniform_loss, film_loss) = (
            by_uniform / self.carrier_rad_per_s,
            by_film / self.carrier_rad_per_s,
        );
        let by_film_loss = uniform_loss * parts.trapped + film_loss * parts.film;
        WideSlopes {
            by_part: [
                by_uniform * self.asperities,
                by_film * self.film,
                by_uniform * self.film,
            ],
            by_z_t: r * r,
            by_ln_loss_factor: self.loss_factor * (uniform_loss * parts.asperities + by_film_loss),
            by_film_loss,
            by_width_square: contact.uniform * square_slope + contact.film * fourth_slope
                - 2.0 * r * (contact.uniform * mean_slope + contact.film * cube_slope),
        }
    }
}

impl WideContact {
    /// Returns Z_c = U + F.
    pub(super) fn z_c(&self) -> Complex64 {
        self.uniform + self.film
    }
}

/// Effect of the laws in doubt on the inversion of a sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SampleLaws {
    /// Reactance due to the plate's amplitude, N·s/m.
    pub(crate) z_p: Complex64,
    /// Its derivative by the softening, µm².
    pub(crate) z_p_by_softening: Complex64,
    /// Ratio of the modelled Z_f to that of a contact without width.
    pub(crate) width_ratio: Complex64,
    /// Derivative of its logarithm by κ.
    pub(crate) ln_ratio_by_width_square: Complex64,
}

impl SampleLaws {
    /// Returns the inversion of the sample.
    pub(crate) fn inversion<const N: usize>(&self, inversion: &Inversion<N>) -> Inversion<N> {
        let mut sample = Inversion {
            z_p: inversion.z_p + self.z_p,
            finger_scale: inversion.finger_scale * self.width_ratio,
            ..*inversion
        };
        // A fit of fewer parameters has the first ones.
        if let Some(slope) = sample.z_p_slopes.get_mut(SOFTENING) {
            *slope += self.z_p_by_softening;
        }
        if let Some(slope) = sample.finger_slopes.get_mut(WIDTH_SQUARE) {
            *slope += self.ln_ratio_by_width_square;
        }
        sample
    }
}

impl LaggedModel<'_> {
    /// Changes the laws that the model follows.
    pub(crate) fn set_laws(&mut self, laws: Laws) {
        self.laws = laws;
        self.gap_slopes.set_laws(laws);
        self.loads.follow_published();
    }

    /// Returns i a_p², by which the softening changes Z_p at a sample, µm².
    pub(super) fn softening_slope(&self, sample: usize) -> Complex64 {
        Complex64::I * (self.amplitude_m[sample] * 1e6).powi(2)
    }

    /// Computes the finger's part of Z_m, by which the skin's motion follows from Z_t. It is the modelled one: the measured one
    /// has the noise of the residuals, which the film's amplitude would then follow.
    pub(crate) fn follow_finger(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let finger = self.finger(parameters, contact)?;
        for sample in 0..self.z_finger.len() {
            self.z_finger[sample] = self.impedance_at(&finger, sample).z_finger;
        }
        Some(())
    }

    /// Returns the laws at each sample of the instance, after [`follow`](Self::follow); `None` with the laws as published.
    pub(crate) fn sample_laws(&self, parameters: &[f64; PARAMETERS]) -> Option<Vec<SampleLaws>> {
        if self.laws == Laws::Published {
            return None;
        }
        let contact = self.contact(parameters)?;
        let z_t = Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]);
        let doubtful = DoubtfulFinger::new(parameters, self.carrier_rad_per_s)?;
        let samples = self.lead..self.gap.len();
        let laws = samples.map(|sample| {
            let contact = self.contact_at(&contact, sample);
            let (gap, amplitude) = (self.gap[sample], self.loads.amplitude_m[sample]);
            let parts = contact.stiffness_parts_n_per_m(gap, amplitude);
            let z_t = self.trend.z_t(z_t, sample);
            let wide = doubtful.contact(&parts, z_t);
            let z_c = wide.z_c();
            let slope = self.softening_slope(sample);
            SampleLaws {
                z_p: slope * parameters[SOFTENING],
                z_p_by_softening: slope,
                width_ratio: wide.z_finger / (z_t * z_c / (z_t + z_c)),
                ln_ratio_by_width_square: doubtful.slopes(&wide, &parts).by_width_square
                    / wide.z_finger,
            }
        });
        Some(laws.collect())
    }
}
