//! Contact area and effective amplitude of the film, sample by sample.
//!
//! The contact area grows with the normal force as S (f_n/f̄)^ν; for finger pads ν is 0.3 to 0.6, less than Hertz's 2/3
//! (Adams et al. 2013). The film responds to the squared amplitude of a moment earlier, because its pressure needs some cycles
//! of the carrier to build up. The published model has neither effect.
//!
//! ```text
//! T d(a²)/dt = |x̃_p|² − a²                                    mean of the squared amplitude over T
//! amplitude at the film = r a e^(y_f g/2),  g = ∂ ln a²/∂y_f    amplitude ratio r, residual mobility y_f of other modes
//! ```
//!
//! With laws in doubt the film follows the plate less a share ρ of the skin's motion, which is Z_f/Z_t that of the plate (Huloux
//! 2021, Eq. 11) with Z_f the finger's part of Z_m at an earlier minimum; over a contact of finite width its mean square is ⟨m²⟩ that at
//! the middle; and the asperities' force is averaged over the cycle with the exponent ι (`contact::cycle_average`):
//!
//! ```text
//! amplitude at the film times |1 − ρ Z_f/Z_t|
//! f_r times I0(√⟨m²⟩ a/σ_t)^ι
//! ```

use contact::first_order_lag::Lag;

use num_complex::Complex64;

use super::trend::Trend;
use contact::Contact;
use contact::cycle_average::CycleAverage;
use contact::inversion::Inversion;
use contact::parameters::LoadSlopes;

/// Effective amplitude of the film and contact area at each sample.
pub(super) struct Loads {
    plate_m: Vec<f64>,
    plate_m2: Vec<f64>,
    film_m2: Vec<f64>,
    by_mean_m2: Vec<f64>,
    /// Effective amplitude of the film, m.
    pub(super) amplitude_m: Vec<f64>,
    /// Contact area relative to the area at the reference force.
    pub(super) area_ratio: Vec<f64>,
    /// Force of the asperities relative to that at the same mean gap without vibration.
    asperity_ratio: Vec<f64>,
    pub(super) slopes: Vec<LoadSlopes>,
}

/// Parameters of the laws in doubt that act on the loads.
pub(super) struct DoubtfulLoadLaw<'a> {
    /// Share ρ of the skin's motion.
    pub(super) relative_share: f64,
    /// Exponent ι of the cycle's average.
    pub(super) cycle_average: f64,
    /// Z_t at the middle of the instance, N·s/m.
    pub(super) z_t: Complex64,
    /// σ_t at the middle of the instance, m.
    pub(super) sigma_t_m: f64,
    /// ⟨m²⟩ and its derivative by the square of the width.
    pub(super) mean_square: (f64, f64),
    /// Change of σ_t and Z_t within the instance.
    pub(super) trend: &'a Trend,
    /// Finger's part of Z_m at an earlier minimum, N·s/m.
    pub(super) z_finger: &'a [Complex64],
}

/// Parameters of the loads.
pub(super) struct LoadLaw {
    /// Exponent ν of the area.
    pub(super) area_exponent: f64,
    /// Logarithm of the amplitude ratio r.
    pub(super) ln_ratio: f64,
    /// Residual mobility y_f of other modes, m/(N·s).
    pub(super) film_mobility: f64,
    /// Time T over which the film averages, sampling intervals.
    pub(super) film_mean_intervals: f64,
    /// Sampling intervals per ms.
    pub(super) intervals_per_ms: f64,
}

impl Loads {
    /// Takes the samples of an instance; the area is S at a normal force of `reference_n`.
    pub(super) fn new(amplitude_m: &[f64], normal_n: &[f64], reference_n: f64) -> Self {
        let n = amplitude_m.len();
        let ln_area_by_exponent = |&normal_n: &f64| (normal_n / reference_n).ln();
        Self {
            plate_m: amplitude_m.to_vec(),
            plate_m2: amplitude_m.iter().map(|a| a * a).collect(),
            film_m2: vec![0.0; n],
            by_mean_m2: vec![0.0; n],
            amplitude_m: amplitude_m.to_vec(),
            area_ratio: vec![1.0; n],
            asperity_ratio: vec![1.0; n],
            slopes: normal_n
                .iter()
                .map(|force_n| LoadSlopes {
                    ln_area_by_exponent: ln_area_by_exponent(force_n),
                    ..LoadSlopes::default()
                })
                .collect(),
        }
    }

    /// Computes the loads; `None` if the film's squared amplitude would not be positive.
    pub(super) fn follow(&mut self, law: &LoadLaw) -> Option<()> {
        let &LoadLaw {
            area_exponent,
            ln_ratio,
            film_mobility,
            film_mean_intervals,
            intervals_per_ms,
        } = law;
        let mean = Lag::new(film_mean_intervals, 1.0);
        if film_mean_intervals == 0.0 {
            self.film_m2.copy_from_slice(&self.plate_m2);
            self.amplitude_m.copy_from_slice(&self.plate_m);
        } else {
            mean.apply(&self.plate_m2, &mut self.film_m2);
        }
        mean.slope(&self.plate_m2, &self.film_m2, &mut self.by_mean_m2);
        for (sample, &film_m2) in self.film_m2.iter().enumerate() {
            if film_m2 <= 0.0 && self.plate_m2[sample] > 0.0 {
                return None;
            }
            let slopes = &mut self.slopes[sample];
            if film_m2 > 0.0 {
                // ∂ ln a²/∂T = (∂a²/∂T)/a², with T in ms rather than in sampling intervals.
                slopes.ln_film_by_mean_ms = self.by_mean_m2[sample] * intervals_per_ms / film_m2;
            }
            if film_mean_intervals != 0.0 {
                self.amplitude_m[sample] = film_m2.sqrt();
            }
            let ln_factor = ln_ratio + 0.5 * film_mobility * slopes.ln_film_by_mobility;
            if ln_factor != 0.0 {
                self.amplitude_m[sample] *= ln_factor.exp();
            }
            self.area_ratio[sample] = if area_exponent == 0.0 {
                1.0
            } else {
                (area_exponent * slopes.ln_area_by_exponent).exp()
            };
        }
        Some(())
    }

    /// Applies the laws in doubt to the loads computed by [`follow`](Self::follow).
    pub(super) fn follow_doubtful(&mut self, law: &DoubtfulLoadLaw<'_>) {
        let (mean_square, mean_square_slope) = law.mean_square;
        for sample in 0..self.amplitude_m.len() {
            let z_t = law.trend.z_t(law.z_t, sample);
            // With W = Z_f/Z_t and c = 1 − ρW: ∂ ln|c|²/∂ρ = 2 Re(−W/c), and ∂W/∂Z_t = −W/Z_t gives
            // ∂ ln|c|²/∂Z_t = 2 Re(ρ W/(c Z_t) dZ_t).
            // A candidate without Z_t yet, at the start of a search, has a skin at rest.
            let mobility = if z_t == Complex64::ZERO {
                Complex64::ZERO
            } else {
                z_t.inv()
            };
            let skin = law.z_finger[sample] * mobility;
            let relative = 1.0 - law.relative_share * skin;
            let by_z_t = 2.0 * law.relative_share * skin * mobility / relative;
            self.amplitude_m[sample] *= relative.norm();
            let sigma_t_m = law.sigma_t_m * law.trend.sigma_ratio(sample);
            let average =
                CycleAverage::new(mean_square.sqrt() * self.amplitude_m[sample] / sigma_t_m);
            self.asperity_ratio[sample] = (law.cycle_average * average.ln).exp();
            let slopes = &mut self.slopes[sample];
            slopes.ln_film_by_relative_share = -2.0 * (skin / relative).re;
            slopes.ln_film_by_z_t = [by_z_t.re, -by_z_t.im];
            slopes.ln_film_by_width_square = mean_square_slope / mean_square;
            // ι ln I0(z), z ∝ √(a²): ∂/∂ ln a² = (ι/2) d ln I0/d ln z.
            slopes.ln_asperity_by_ln_film = 0.5 * law.cycle_average * average.by_ln_argument;
            slopes.ln_asperity_by_cycle_average = average.ln;
        }
    }

    /// Restores the laws as published.
    pub(super) fn follow_published(&mut self) {
        self.asperity_ratio.fill(1.0);
        for slopes in &mut self.slopes {
            *slopes = LoadSlopes {
                ln_area_by_exponent: slopes.ln_area_by_exponent,
                ln_film_by_mobility: slopes.ln_film_by_mobility,
                ..LoadSlopes::default()
            };
        }
    }

    /// Returns the inversion under the load of a sample.
    pub(super) fn inversion<const N: usize>(
        &self,
        inversion: &Inversion<N>,
        sample: usize,
    ) -> Inversion<N> {
        Inversion {
            contact: self.contact(&inversion.contact, sample),
            load: self.slopes[sample],
            ..*inversion
        }
    }

    /// Returns the contact under the load of a sample.
    pub(super) fn contact(&self, contact: &Contact, sample: usize) -> Contact {
        contact
            .with_area_ratio(self.area_ratio[sample])
            .with_asperity_ratio(self.asperity_ratio[sample])
    }
}
