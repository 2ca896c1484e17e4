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

use contact::first_order_lag::Lag;

use contact::Contact;
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
    pub(super) slopes: Vec<LoadSlopes>,
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
            slopes: normal_n
                .iter()
                .map(|force_n| LoadSlopes {
                    ln_area_by_exponent: ln_area_by_exponent(force_n),
                    ln_film_by_mean_ms: 0.0,
                    ln_film_by_mobility: 0.0,
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
        contact.with_area_ratio(self.area_ratio[sample])
    }
}
